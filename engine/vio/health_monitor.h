// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/vio/filter_state.h"
#include "engine/vio/vio_report.h"

namespace plumbline {

/// What is wrong with a filter.
struct Health {
  bool lost = false;       ///< The state is not to be believed: start anew.
  bool disagrees = false;  ///< Lost because points contradict the IMU: a clock may have moved.
  std::string message;     ///< One sentence; "" where all is well.
};

/// Watches a filter's innovations, state and covariance from image to image.
class HealthMonitor {
 public:
  Health Check(const FilterState& state, const FilterStep& step, double seconds_since_last);
  void Reset() { *this = HealthMonitor(); }

 private:
  double blind_s_ = 0;         ///< Time without any accepted measurement.
  double rejected_share_ = 0;  ///< Of the measurements, lately.
  double rejecting_s_ = 0;     ///< Time in which it was too large.
  double nis_ratio_ = 1;       ///< Smoothed.
};

}  // namespace plumbline
