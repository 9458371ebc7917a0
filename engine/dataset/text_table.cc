// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/text_table.h"

#include <algorithm>
#include <charconv>
#include <limits>

namespace plumbline {

std::vector<std::string_view> SplitLines(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.push_back(line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

std::vector<std::string_view> SplitFields(std::string_view line) {
  constexpr std::string_view kSeparators = ", \t";
  std::vector<std::string_view> fields;
  std::size_t begin = line.find_first_not_of(kSeparators);
  while (begin != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(kSeparators, begin), line.size());
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kSeparators, end);
  }
  return fields;
}

std::optional<double> ParseNumber(std::string_view field) {
  if (field.starts_with('+')) field.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  if (error != std::errc() || end != field.data() + field.size() || field.empty())
    return std::nullopt;
  return value;
}

std::optional<std::int64_t> ParseStampNs(std::string_view field) {
  const bool negative = field.starts_with('-');
  if (negative || field.starts_with('+')) field.remove_prefix(1);
  int exponent = 0;
  const std::size_t letter = field.find_first_of("eE");
  const bool has_exponent = letter != std::string_view::npos;
  if (has_exponent) {
    std::string_view power = field.substr(letter + 1);
    if (power.starts_with('+')) power.remove_prefix(1);
    const auto [end, error] = std::from_chars(power.data(), power.data() + power.size(), exponent);
    if (error != std::errc() || end != power.data() + power.size() || exponent < -40 ||
        exponent > 40)
      return {};
    field = field.substr(0, letter);
  }
  std::string digits;
  bool point = false;
  for (const char c : field) {
    if (c == '.' && !point) {
      point = true;
    } else if (c >= '0' && c <= '9') {
      digits += c;
      if (point) --exponent;
    } else {
      return std::nullopt;
    }
  }
  if (digits.empty()) return std::nullopt;
  digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size() - 1));
  const bool nanoseconds =
      !point && !has_exponent &&
      (digits.size() > 13 || (digits.size() == 13 && digits > "1000000000000"));
  if (!nanoseconds) exponent += 9;
  bool round_up = false;
  if (exponent < 0) {
    const std::size_t drop =
        std::min<std::size_t>(static_cast<std::size_t>(-exponent), digits.size() + 1);
    if (drop > digits.size()) digits.insert(0, drop - digits.size(), '0');
    round_up = digits[digits.size() - drop] >= '5';
    digits.resize(digits.size() - drop);
  } else if (digits != "0") {
    digits.append(static_cast<std::size_t>(exponent), '0');
  }
  if (digits.empty()) digits = "0";
  std::int64_t value = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || value == std::numeric_limits<std::int64_t>::max())
    return std::nullopt;
  value += round_up ? 1 : 0;
  return negative ? -value : value;
}

void LineWarnings::Add(std::string_view what, std::size_t line) {
  for (Kind& kind : kinds_) {
    if (kind.what == what) {
      ++kind.count;
      return;
    }
  }
  kinds_.push_back({std::string(what), line, 1});
}

std::vector<std::string> LineWarnings::Sentences() const {
  std::vector<std::string> sentences;
  for (const Kind& kind : kinds_) {
    const std::string more =
        kind.count > 1 ? " (and " + std::to_string(kind.count - 1) + " more)" : "";
    sentences.push_back("'" + file_ + "' line " + std::to_string(kind.first_line) + more + ": " +
                        kind.what);
  }
  return sentences;
}

}  // namespace plumbline
