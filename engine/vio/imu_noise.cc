// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/imu_noise.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr double kStill_s = 1, kMemory_s = 0.5;
constexpr double kSecondDifference = 6;  ///< Its variance, of white noise with variance 1.
constexpr double kEven = 1.5;            ///< Steps longer than this many periods are gaps.

/// Mean square of the three axes of the second difference.
double Square(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  return (a - 2 * b + c).squaredNorm() / 3;
}

double Density(double mean_square, double rate_hz) {
  return std::sqrt(mean_square / kSecondDifference / rate_hz);
}

double RateOf(std::span<const ImuSample> samples) {
  return 1e9 * static_cast<double>(samples.size() - 1) /
         static_cast<double>(samples.back().stamp_ns - samples.front().stamp_ns);
}

}  // namespace

ImuNoise MeasureImuNoise(std::span<const ImuSample> samples) {
  if (samples.size() < 3) return {};
  double gyro = 0, accel = 0;
  for (std::size_t i = 2; i < samples.size(); ++i) {
    const ImuSample &a = samples[i - 2], &b = samples[i - 1], &c = samples[i];
    gyro += Square(a.angular_velocity_rad_s, b.angular_velocity_rad_s, c.angular_velocity_rad_s);
    accel += Square(a.specific_force_m_s2, b.specific_force_m_s2, c.specific_force_m_s2);
  }
  const auto count = static_cast<double>(samples.size() - 2);
  const double rate_hz = RateOf(samples);
  return {Density(gyro / count, rate_hz), Density(accel / count, rate_hz)};
}

ImuNoise MeasureStillestNoise(std::span<const ImuSample> samples) {
  if (samples.size() < 3) return {};
  const auto window = std::clamp(static_cast<std::size_t>(RateOf(samples) * kStill_s),
                                 std::size_t{3}, samples.size());
  constexpr double kMost = std::numeric_limits<double>::infinity();
  ImuNoise least{kMost, kMost};
  for (std::size_t i = 0; i + window <= samples.size(); i += std::max<std::size_t>(1, window / 4)) {
    const ImuNoise noise = MeasureImuNoise(samples.subspan(i, window));
    least.gyro_density = std::min(least.gyro_density, noise.gyro_density);
    least.accel_density = std::min(least.accel_density, noise.accel_density);
  }
  return least;
}

void VibrationMeter::Add(const ImuSample& sample) {
  const double longest_ns = kEven * 1e9 / rate_hz_;
  if (!last_.empty() && static_cast<double>(sample.stamp_ns - last_.back().stamp_ns) > longest_ns)
    last_.clear();
  if (last_.size() == 2) {
    const double keep = std::exp(-1 / (rate_hz_ * kMemory_s));
    gyro_ = keep * gyro_ + Square(last_[0].angular_velocity_rad_s, last_[1].angular_velocity_rad_s,
                                  sample.angular_velocity_rad_s);
    accel_ = keep * accel_ + Square(last_[0].specific_force_m_s2, last_[1].specific_force_m_s2,
                                    sample.specific_force_m_s2);
    weight_ = keep * weight_ + 1;
    last_.pop_front();
  }
  last_.push_back(sample);
}

void VibrationMeter::Clear() { *this = VibrationMeter(rate_hz_); }

ImuNoise VibrationMeter::noise() const {
  if (weight_ <= 0) return {};
  return {Density(gyro_ / weight_, rate_hz_), Density(accel_ / weight_, rate_hz_)};
}

}  // namespace plumbline
