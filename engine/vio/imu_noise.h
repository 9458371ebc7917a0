// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <span>

#include "engine/sensor/imu.h"

namespace plumbline {

/// White noise of an IMU, as densities in continuous time.
struct ImuNoise {
  double gyro_density = 0;   ///< [rad/s/sqrt(Hz)]
  double accel_density = 0;  ///< [m/s^2/sqrt(Hz)]
};

/// What readings scatter by beside a smooth motion: of white noise with variance s^2 second
/// differences have 6 s^2, while a hand moves little in two periods.
/// @param samples  By rising stamp, evenly spaced but for gaps. Fewer than three: 0.
ImuNoise MeasureImuNoise(std::span<const ImuSample> samples);

/// The least of that over all stretches of one second: the noise of the IMU itself, at most.
ImuNoise MeasureStillestNoise(std::span<const ImuSample> samples);

/// The same of the last half second, reading by reading. What shakes the body between readings
/// (rotors, an engine, steps) is noise to whoever integrates them.
class VibrationMeter {
 public:
  explicit VibrationMeter(double rate_hz) : rate_hz_(rate_hz) {}

  void Add(const ImuSample& sample);
  void Clear();
  ImuNoise noise() const;

 private:
  double rate_hz_;
  std::deque<ImuSample> last_;  ///< At most two.
  double gyro_ = 0, accel_ = 0, weight_ = 0;
};

}  // namespace plumbline
