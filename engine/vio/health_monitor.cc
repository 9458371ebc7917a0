// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/health_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace plumbline {
namespace {

constexpr double kMaxSpeed = 40;        // [m/s]
constexpr double kMaxGyroBias = 1;      // [rad/s]
constexpr double kMaxAccelBias = 4;     // [m/s^2]
constexpr double kMaxBlindSeconds = 8;  // an IMU of a phone is off by metres then
constexpr double kMaxVelocityStd = 3;   // [m/s]
constexpr double kMaxRejectingSeconds = 3;
constexpr double kWarnSeconds = 0.5;
constexpr double kHighNis = 3;

template <typename... Arguments>
std::string Sentence(const char* format, Arguments... arguments) {
  char text[200];
  std::snprintf(text, sizeof(text), format, arguments...);
  return text;
}

}  // namespace

Health HealthMonitor::Check(const FilterState& state, const FilterStep& step,
                            double seconds_since_last) {
  const double dt = std::max(seconds_since_last, 0.0);
  blind_s_ = step.accepted > 0 ? 0 : blind_s_ + dt;
  const bool rejecting = step.rejected >= 4 && step.rejected > 2 * step.accepted;
  rejecting_s_ = rejecting ? rejecting_s_ + dt : std::max(rejecting_s_ - dt, 0.0);
  if (step.nis_dof > 0) nis_ratio_ += 0.05 * (std::min(step.nis / step.nis_dof, 10.0) - nis_ratio_);

  const InertialState& inertial = state.inertial();
  if (!state.finite()) return {true, "the filter's numbers are no longer finite"};
  const double speed = inertial.velocity_in_world.norm();
  if (speed > kMaxSpeed) return {true, Sentence("the velocity has run away to %.0f m/s", speed)};
  if (inertial.gyro_bias.norm() > kMaxGyroBias || inertial.accel_bias.norm() > kMaxAccelBias) {
    return {true, Sentence("the biases have run away to %.2f rad/s and %.1f m/s^2",
                           inertial.gyro_bias.norm(), inertial.accel_bias.norm())};
  }
  const double spread = std::sqrt(state.covariance().diagonal().segment<3>(kXiV).maxCoeff());
  if (blind_s_ > kMaxBlindSeconds && spread > kMaxVelocityStd) {
    return {true, Sentence("no point could be used for %.1f s; the IMU alone is too uncertain",
                           blind_s_)};
  }
  if (rejecting_s_ > kMaxRejectingSeconds) {
    return {true, Sentence("for %.1f s nearly all points disagreed with the state: the IMU, its "
                           "calibration or the tracks are wrong",
                           rejecting_s_)};
  }
  if (blind_s_ > kWarnSeconds)
    return {false, Sentence("no point could be used for %.1f s: the IMU alone", blind_s_)};
  if (rejecting_s_ > kWarnSeconds)
    return {false, Sentence("for %.1f s most points disagreed with the state", rejecting_s_)};
  if (nis_ratio_ > kHighNis) {
    return {false, Sentence("innovations are %.1f times what they should be: the noise of pixels "
                            "or IMU is stated too small",
                            nis_ratio_)};
  }
  return {};
}

}  // namespace plumbline
