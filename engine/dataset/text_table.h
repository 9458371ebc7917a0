// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline {

/// The lines of a text without their ends (\n or \r\n) and without a byte order mark. The views
/// point into `text`.
std::vector<std::string_view> SplitLines(std::string_view text);

/// The fields of a line between commas, spaces and tabs; empty ones are dropped. The views point
/// into `line`.
std::vector<std::string_view> SplitFields(std::string_view line);

/// A number that fills the whole field; nan and inf are numbers. Nothing for other text.
std::optional<double> ParseNumber(std::string_view field);

/// A stamp [ns]: decimal seconds, or whole nanoseconds where there is no decimal point and the
/// number exceeds 1e12. Read digit by digit, so that 1403636579.763555584 keeps its last
/// nanosecond; digits beyond are rounded. Nothing for text that is no number or that does not fit.
std::optional<std::int64_t> ParseStampNs(std::string_view field);

/// Collects what is odd in many lines of one file into one sentence a kind.
class LineWarnings {
 public:
  /// @param file  As it is to be named.
  explicit LineWarnings(std::string file) : file_(std::move(file)) {}
  /// @param line  Counted from 1.
  void Add(std::string_view what, std::size_t line);
  /// `'file' line 7 (and 3 more): what`, in the order of first sight.
  std::vector<std::string> Sentences() const;

 private:
  struct Kind {
    std::string what;
    std::size_t first_line;
    int count;
  };
  std::string file_;
  std::vector<Kind> kinds_;
};

}  // namespace plumbline
