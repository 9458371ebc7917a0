// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/stamped_rows.h"

#include <cmath>
#include <optional>

#include "engine/base/files.h"
#include "engine/dataset/text_table.h"

namespace plumbline {
namespace {

/// What is wrong with the row, or nothing and its numbers.
std::optional<std::string> ReadRow(std::span<const std::string_view> fields,
                                   const RowFormat& format, std::vector<double>& numbers) {
  if (static_cast<int>(fields.size()) != format.numbers + 1)
    return "not a row '" + std::string(format.columns) + "'; left out";
  for (int i = 0; i < format.numbers; ++i) {
    const std::optional<double> number = ParseNumber(fields[static_cast<std::size_t>(i) + 1]);
    if (!number) return "not a row '" + std::string(format.columns) + "'; left out";
    if (!std::isfinite(*number)) return std::string("a number is not finite; row left out");
    numbers[static_cast<std::size_t>(i)] = *number;
  }
  return std::nullopt;
}

}  // namespace

Result<std::vector<std::string>> ReadStampedRows(
    const std::filesystem::path& file, const RowFormat& format,
    const std::function<void(std::int64_t stamp_ns, std::span<const double> numbers)>& row) {
  const Result<std::string> text = ReadFile(file);
  if (!text.ok()) return text.error();
  LineWarnings warnings(file.string());
  std::vector<double> numbers(static_cast<std::size_t>(format.numbers));
  const std::vector<std::string_view> lines = SplitLines(text.value());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string_view> fields = SplitFields(lines[i]);
    if (fields.empty() || fields[0].starts_with('#')) continue;
    const std::optional<std::int64_t> stamp = ParseStampNs(fields[0]);
    if (!stamp && i == 0) continue;
    if (!stamp) {
      warnings.Add("the stamp is not a number; row left out", i + 1);
    } else if (const auto problem = ReadRow(fields, format, numbers)) {
      warnings.Add(*problem, i + 1);
    } else {
      row(*stamp, numbers);
    }
  }
  return warnings.Sentences();
}

}  // namespace plumbline
