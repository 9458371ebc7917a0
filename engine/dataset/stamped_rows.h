// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.h"

namespace plumbline {

/// What the rows of a table are, for reading and for messages.
struct RowFormat {
  std::string_view columns;  ///< As `t,wx,wy,wz,ax,ay,az`.
  int numbers = 0;           ///< After the stamp.
};

/// Reads a table whose rows are a stamp and numbers. Lines that begin with # and a heading in the
/// first line are passed over; rows that are incomplete or not finite are left out with a warning.
/// @param row  Gets each row in the order of the file; `numbers` are valid during the call.
/// @return What was odd, one sentence a kind. Errors: kNotFound, kIo, naming the file.
Result<std::vector<std::string>> ReadStampedRows(
    const std::filesystem::path& file, const RowFormat& format,
    const std::function<void(std::int64_t stamp_ns, std::span<const double> numbers)>& row);

/// Sorts by `stamp_ns` and keeps the first of equal stamps; adds a sentence where that changed
/// something.
/// @param what  As "IMU samples".
template <typename Stamped>
void MakeStampsRise(const std::filesystem::path& file, std::string_view what,
                    std::vector<Stamped>& rows, std::vector<std::string>& warnings) {
  const auto earlier = [](const Stamped& a, const Stamped& b) { return a.stamp_ns < b.stamp_ns; };
  const auto same = [](const Stamped& a, const Stamped& b) { return a.stamp_ns == b.stamp_ns; };
  if (!std::is_sorted(rows.begin(), rows.end(), earlier)) {
    warnings.push_back("'" + file.string() + "' has " + std::string(what) +
                       " whose stamps do not rise; sorted");
    std::stable_sort(rows.begin(), rows.end(), earlier);
  }
  const std::size_t all = rows.size();
  rows.erase(std::unique(rows.begin(), rows.end(), same), rows.end());
  if (rows.size() == all) return;
  warnings.push_back("'" + file.string() + "' has " + std::to_string(all - rows.size()) + " " +
                     std::string(what) + " with the stamp of another; the first of each counts");
}

}  // namespace plumbline
