// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

namespace plumbline {

/// How regularly something was recorded.
struct StampStatistics {
  std::int64_t first_ns = 0, last_ns = 0;
  double median_step_s = 0;   ///< 0 for fewer than two stamps.
  double longest_step_s = 0;  ///< Likewise.
  int longest_after = 0;      ///< Index of the stamp before the longest step.
  int gaps = 0;               ///< Steps longer than `gap_factor` median steps.

  double rate_hz() const { return median_step_s > 0 ? 1 / median_step_s : 0; }
  double span_s() const { return static_cast<double>(last_ns - first_ns) * 1e-9; }
};

/// @param stamps_ns  Rising.
StampStatistics StatisticsOf(std::span<const std::int64_t> stamps_ns, double gap_factor);

}  // namespace plumbline
