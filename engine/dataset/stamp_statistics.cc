// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/stamp_statistics.h"

#include <algorithm>
#include <vector>

namespace plumbline {

StampStatistics StatisticsOf(std::span<const std::int64_t> stamps_ns, double gap_factor) {
  StampStatistics result;
  if (stamps_ns.empty()) return result;
  result.first_ns = stamps_ns.front();
  result.last_ns = stamps_ns.back();
  if (stamps_ns.size() < 2) return result;
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i)
    steps.push_back(static_cast<double>(stamps_ns[i] - stamps_ns[i - 1]) * 1e-9);
  const auto longest = std::max_element(steps.begin(), steps.end());
  result.longest_step_s = *longest;
  result.longest_after = static_cast<int>(longest - steps.begin());
  std::vector<double> sorted = steps;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  result.median_step_s = *middle;
  for (const double step : steps) result.gaps += step > gap_factor * *middle;
  return result;
}

}  // namespace plumbline
