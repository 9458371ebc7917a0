// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutation.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/fuzz/packed_files.h"

namespace plumbline::fuzz {
namespace {

using nlohmann::json;

constexpr std::array<const char*, 24> kNumbers = {
    "0",           "-1",         "1",          "-0",    "0.5",    "2",
    "1e300",       "-1e300",     "1e-300",     "1e5",   "-1e5",   "nan",
    "inf",         "-inf",       "2147483647", "65536", "100000", "2147483648",
    "-2147483649", "4294967295", "1e19",       "",      "x",      "9223372036854775807"};

std::size_t Below(Random& random, std::size_t n) {
  return random.Index(static_cast<std::uint32_t>(std::max<std::size_t>(n, 1)));
}

json OddValue(Random& random) {
  switch (random.Index(10)) {
    case 0:
      return nullptr;
    case 1:
      return json::array();
    case 2:
      return json::object();
    case 3:
      return random.Index(2) == 0;
    case 4:
      return std::array{"", "x", "a/../../b", "/", "\xc3\xa9", "nan"}[random.Index(6)];
    case 5:
      return json::array({json::array(), 0, "x"});
    case 6:
      return std::numeric_limits<std::uint64_t>::max() >> random.Index(64);
    case 7:
      return std::array{1e300, -1e300, 1e-300, 0.5, 1e20, -1e10, 1e5}[random.Index(7)];
    case 8:
      return -static_cast<std::int64_t>(std::uint64_t{1} << random.Index(63));
    default:
      return static_cast<int>(random.Index(20)) - 5;
  }
}

void CollectNodes(json& node, std::vector<json*>& nodes) {
  nodes.push_back(&node);
  if (!node.is_structured()) return;
  for (auto& child : node) CollectNodes(child, nodes);
}

void MutateJson(json& root, Random& random) {
  std::vector<json*> nodes;
  CollectNodes(root, nodes);
  json& node = *nodes[Below(random, nodes.size())];
  const std::size_t at = Below(random, node.size());
  switch (random.Index(5)) {
    case 0:
      if (node.is_structured() && !node.empty()) {
        node.erase(std::next(node.begin(), static_cast<std::ptrdiff_t>(at)));
        return;
      }
      break;
    case 1:
      if (node.is_array() && !node.empty()) {
        const json twin = node[at];
        node.insert(node.begin() + static_cast<std::ptrdiff_t>(at), twin);
        return;
      }
      break;
    case 2: {  // a value from elsewhere in the same file
      const json other = *nodes[Below(random, nodes.size())];
      node = other;
      return;
    }
    case 3:
      if (node.is_number()) {
        node = node.get<double>() * std::array{-1.0, 0.0, 1e-9, 1e9, 1.001, 1e200}[random.Index(6)];
        return;
      }
      break;
    default:
      break;
  }
  node = OddValue(random);
}

void MutateLine(std::string& text, Random& random) {
  const std::size_t somewhere = Below(random, text.size());
  const std::size_t before = text.rfind('\n', somewhere);
  const std::size_t begin = before == std::string::npos || before == somewhere ? 0 : before + 1;
  const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
  const std::string line = text.substr(begin, end - begin);
  switch (random.Index(3)) {
    case 0:
      text.erase(begin, line.size());
      break;
    case 1:
      text.insert(begin, line);
      break;
    default:
      text.erase(begin, line.size()).insert(Below(random, text.size() + 1), line);
  }
}

/// Whatever stands between separators, most often a number.
void MutateWord(std::string& text, Random& random) {
  const auto separates = [](unsigned char c) {
    return std::isspace(c) || c == ',' || c == ':' || c == '[' || c == ']' || c == '=' || c == '/';
  };
  std::size_t begin = Below(random, text.size()), end = begin;
  while (begin > 0 && !separates(static_cast<unsigned char>(text[begin - 1]))) --begin;
  while (end < text.size() && !separates(static_cast<unsigned char>(text[end]))) ++end;
  text.replace(begin, end - begin, kNumbers[random.Index(kNumbers.size())]);
}

void MutateBytes(std::string& bytes, Random& random) {
  const std::size_t at = Below(random, bytes.size());
  const std::size_t length = 1 + Below(random, std::min<std::size_t>(bytes.size() - at, 32));
  switch (random.Index(7)) {
    case 0:
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.Index(8)));
      break;
    case 1:
      bytes[at] = static_cast<char>(random.Index(256));
      break;
    case 2:
      bytes.erase(at, length);
      break;
    case 3:
      bytes.insert(at, bytes.substr(at, length));
      break;
    case 4:
      bytes.insert(at, 1, static_cast<char>(random.Index(256)));
      break;
    case 5:
      bytes.resize(at);
      break;
    default: {  // a count, an index or a size
      const std::uint32_t value = std::array<std::uint32_t, 6>{
          0, 1, 0x7fffffff, 0x80000000, 0xffffffff, 0x10000}[random.Index(6)];
      for (std::size_t i = 0; i < 4 && at + i < bytes.size(); ++i)
        bytes[at + i] = static_cast<char>(value >> (8 * i));
    }
  }
}

bool IsText(std::string_view bytes) {
  return std::all_of(bytes.begin(), bytes.end(),
                     [](unsigned char c) { return c >= 0x20 || c == '\n' || c == '\t'; });
}

std::string MutateFile(std::string content, Random& random) {
  if (content.empty()) return std::string(1, static_cast<char>(random.Index(256)));
  if (IsText(content) && random.Index(5) > 0) {
    const std::size_t first = content.find_first_not_of(" \n\t");
    if (first != std::string::npos && (content[first] == '{' || content[first] == '[')) {
      json root = json::parse(content, nullptr, false, true);
      if (!root.is_discarded()) {
        MutateJson(root, random);
        return root.dump(-1, ' ', false, json::error_handler_t::replace);
      }
    }
    if (random.Index(2) == 0) {
      MutateLine(content, random);
    } else {
      MutateWord(content, random);
    }
    return content;
  }
  MutateBytes(content, random);
  return content;
}

}  // namespace

std::string Mutate(std::string_view input, Random& random) {
  std::vector<PackedFile> files = SplitFiles(input);
  const bool packed = !files.empty();
  if (!packed) files.push_back({"", std::string(input)});
  for (std::uint32_t left = 1 + random.Index(4); left > 0 && !files.empty(); --left) {
    const std::size_t at = Below(random, files.size());
    if (packed && random.Index(30) == 0) {
      files.erase(files.begin() + static_cast<std::ptrdiff_t>(at));
    } else {
      files[at].content = MutateFile(std::move(files[at].content), random);
    }
  }
  return packed ? JoinFiles(files) : files.front().content;
}

}  // namespace plumbline::fuzz
