// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "engine/sensor/imu.h"
#include "engine/vio/imu_noise.h"

namespace plumbline {

inline std::int64_t Nanoseconds(double seconds) {
  return static_cast<std::int64_t>(std::llround(seconds * 1e9));
}

enum class ImuFlaw { kNone, kGap, kSaturated };

/// A stretch of time in which the IMU's readings are taken as constant: their mean.
struct ImuSegment {
  std::int64_t begin_ns = 0, end_ns = 0;
  Eigen::Vector3d angular_velocity_rad_s{0, 0, 0};
  Eigen::Vector3d specific_force_m_s2{0, 0, 0};
  /// Above 1 where the readings are not to be trusted: in a gap, or saturated.
  double noise_factor = 1;
  ImuFlaw flaw = ImuFlaw::kNone;

  double seconds() const { return static_cast<double>(end_ns - begin_ns) * 1e-9; }
};

/// The recent readings of an IMU, by time.
class ImuBuffer {
 public:
  explicit ImuBuffer(const ImuCalibration& calibration);

  /// Readings must come by rising stamp; others, and those that are not finite, are dropped.
  /// @return whether it was kept.
  bool Add(const ImuSample& sample);
  void Clear() {
    samples_.clear();
    vibration_.Clear();
  }
  /// Forgets what is older, but for one reading before it.
  void DropBefore(std::int64_t stamp_ns);

  bool empty() const { return samples_.empty(); }
  const std::deque<ImuSample>& samples() const { return samples_; }
  bool Covers(std::int64_t stamp_ns) const {
    return !samples_.empty() && samples_.back().stamp_ns >= stamp_ns;
  }

  /// Interpolated linearly; before the first and after the last reading, that reading. Nothing in
  /// an empty buffer.
  std::optional<ImuSample> At(std::int64_t stamp_ns) const;

  /// The time from `begin_ns` to `end_ns` cut at the readings; gaps are cut every 10 ms and carry
  /// a high `noise_factor`. Empty for an empty buffer or no time.
  std::vector<ImuSegment> Between(std::int64_t begin_ns, std::int64_t end_ns) const;

  /// What the readings scatter by of late.
  ImuNoise noise() const { return vibration_.noise(); }
  int dropped() const { return dropped_; }  ///< Readings that were not kept.

 private:
  bool Saturated(const ImuSample& sample) const;

  ImuCalibration calibration_;
  std::int64_t gap_ns_;
  std::deque<ImuSample> samples_;
  VibrationMeter vibration_;
  int dropped_ = 0;
};

}  // namespace plumbline
