// SPDX-License-Identifier: Apache-2.0
#include "engine/models/collada_check.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace plumbline {
namespace {

constexpr std::string_view kSpace = " \t\r\n";

/// One tag, and the text behind it.
struct Tag {
  std::string_view name;
  bool opens = false, closes = false;  ///< `<a/>` does both.
  std::map<std::string_view, std::string_view> attributes;
  std::string_view text;
};

/// Tag after tag; comments, sections of plain characters and declarations are tags without a name.
class TagReader {
 public:
  explicit TagReader(std::string_view text) : text_(text), at_(text.find('<')) {}

  std::optional<Tag> Next() {
    if (at_ >= text_.size()) return std::nullopt;
    Tag tag;
    for (const auto& [begin, end] : {std::pair("<!--", "-->"), std::pair("<![CDATA[", "]]>"),
                                     std::pair("<?", "?>"), std::pair("<!", ">")}) {
      if (!text_.substr(at_).starts_with(begin)) continue;
      const std::size_t closed = text_.find(end, at_);
      if (closed == std::string_view::npos) return std::nullopt;
      if (std::string_view(begin) == "<![CDATA[")
        tag.text = text_.substr(at_ + 9, closed - at_ - 9);
      at_ = closed + std::string_view(end).size() - 1;
      return WithText(std::move(tag));
    }
    ++at_;
    tag.closes = Peek() == '/';
    tag.opens = !tag.closes;
    if (tag.closes) ++at_;
    tag.name = Until(" \t\r\n/>");
    while (at_ < text_.size() && Peek() != '>') ReadAttribute(tag);
    return WithText(std::move(tag));
  }

 private:
  char Peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  std::string_view Until(std::string_view any) {
    const std::size_t end = std::min(text_.find_first_of(any, at_), text_.size());
    const std::size_t begin = std::exchange(at_, end);
    return text_.substr(begin, end - begin);
  }
  void SkipSpace() { at_ = std::min(text_.find_first_not_of(kSpace, at_), text_.size()); }

  void ReadAttribute(Tag& tag) {
    SkipSpace();
    if (Peek() == '/') {
      tag.closes = true;
      ++at_;
      return;
    }
    const std::string_view name = Until(" \t\r\n=/>");
    SkipSpace();
    if (Peek() != '=') return;
    ++at_;
    SkipSpace();
    const char quote = Peek();
    if (quote != '"' && quote != '\'') return;
    ++at_;
    tag.attributes.emplace(name, Until(std::string_view(&quote, 1)));
    if (at_ < text_.size()) ++at_;
  }

  /// From the '>' of a tag to the next tag.
  Tag WithText(Tag tag) {
    if (at_ < text_.size()) ++at_;
    const std::size_t end = std::min(text_.find('<', at_), text_.size());
    if (tag.text.empty()) tag.text = text_.substr(at_, end - at_);
    at_ = end;
    return tag;
  }

  std::string_view text_;
  std::size_t at_;
};

/// A whole number from 0; nothing for any other text.
std::optional<std::uint64_t> Whole(std::string_view text) {
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == std::string_view::npos) return std::nullopt;
  text = text.substr(begin, text.find_last_not_of(kSpace) + 1 - begin);
  std::uint64_t number = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = read.ec == std::errc() && read.ptr == text.data() + text.size();
  return whole ? std::optional(number) : std::nullopt;
}

class ColladaCheck {
 public:
  explicit ColladaCheck(std::string_view text) : text_(text) {}

  std::string Problem() {
    TagReader tags(text_);
    while (const auto tag = tags.Next()) {
      if (std::string problem = ProblemOf(*tag); !problem.empty()) return problem;
    }
    return ProblemOfAccessors();
  }

 private:
  struct Accessor {
    std::string_view array;
    std::uint64_t offset = 0, count = 0, stride = 1, params = 0;
  };

  std::string ProblemOf(const Tag& tag) {
    if (tag.name == "mesh") in_mesh_ = tag.opens && !tag.closes;
    for (const char* key : {"count", "offset", "stride"}) {
      const auto number = tag.attributes.find(key);
      // Each thing that is counted takes a byte at least.
      if (number != tag.attributes.end() && Whole(number->second).value_or(kNone) > text_.size())
        return std::string(key) + " of an element <" + std::string(tag.name) + "> is '" +
               std::string(number->second.substr(0, 20)) + "'";
    }
    if (tag.opens) Note(tag);
    return ProblemOfNumbers(tag);
  }

  void Note(const Tag& tag) {
    const auto text = [&](const char* key) {
      const auto found = tag.attributes.find(key);
      return found == tag.attributes.end() ? std::string_view() : found->second;
    };
    const auto number = [&](const char* key, std::uint64_t otherwise) {
      return Whole(text(key)).value_or(otherwise);
    };
    if (tag.name == "source") source_ = text("id");
    if (tag.name == "float_array") {
      const auto [array, is_new] = arrays_.emplace(text("id"), number("count", 0));
      if (!is_new) array->second = std::min(array->second, number("count", 0));
    }
    if (tag.name == "Name_array" || tag.name == "IDREF_array") sources_of_words_.insert(source_);
    if (tag.name == "accessor") {
      std::string_view array = text("source");
      if (!array.empty()) array.remove_prefix(1);
      accessors_.push_back({array, number("offset", 0), number("count", 0), number("stride", 1)});
    }
    if (tag.name == "param" && !accessors_.empty()) ++accessors_.back().params;
    if (tag.name == "input" && in_mesh_ && !text("source").empty())
      inputs_.insert(text("source").substr(1));
  }

  std::string ProblemOfNumbers(const Tag& tag) {
    static constexpr std::array<std::string_view, 4> kOfIndices = {"p", "v", "vcount", "h"};
    if (!tag.name.empty()) {
      const bool indices =
          std::find(kOfIndices.begin(), kOfIndices.end(), tag.name) != kOfIndices.end();
      indices_of_ = indices && tag.opens && !tag.closes ? tag.name : std::string_view();
    }
    if (indices_of_.empty()) return "";
    std::uint64_t sum = 0;
    for (std::size_t at = tag.text.find_first_not_of(kSpace); at != std::string_view::npos;
         at = tag.text.find_first_not_of(kSpace, at)) {
      const std::size_t end = std::min(tag.text.find_first_of(kSpace, at), tag.text.size());
      const std::string_view word = tag.text.substr(at, end - at);
      at = end;
      const bool none = word == "-1";  // a weight of no joint
      const std::uint64_t number = none ? 0 : Whole(word).value_or(kNone);
      if (number > text_.size())
        return "an element <" + std::string(indices_of_) + "> has '" +
               std::string(word.substr(0, 20)) + "' for an index";
      sum += number;
    }
    return indices_of_ == "vcount" && sum > text_.size() ? "its polygons have too many corners"
                                                         : "";
  }

  std::string ProblemOfAccessors() const {
    for (const Accessor& accessor : accessors_) {
      const auto array = arrays_.find(accessor.array);
      if (array == arrays_.end()) continue;  // of words; or of nothing, which assimp tells
      const std::uint64_t last = accessor.count == 0 ? 0 : accessor.count - 1;
      const std::uint64_t read = std::max(accessor.stride, accessor.params);
      if (accessor.count > 0 && accessor.offset + last * accessor.stride + read > array->second)
        return "the array '" + std::string(accessor.array.substr(0, 60)) +
               "' is shorter than what is read of it";
    }
    for (const std::string_view source : sources_of_words_) {
      if (inputs_.contains(source)) return "a mesh is made of words";
    }
    return "";
  }

  static constexpr auto kNone = std::numeric_limits<std::uint64_t>::max();
  std::string_view text_;
  bool in_mesh_ = false;
  std::string_view source_, indices_of_;
  std::map<std::string_view, std::uint64_t> arrays_;
  std::set<std::string_view> sources_of_words_, inputs_;
  std::vector<Accessor> accessors_;
};

}  // namespace

std::string ColladaProblem(std::string_view text) { return ColladaCheck(text).Problem(); }

}  // namespace plumbline
