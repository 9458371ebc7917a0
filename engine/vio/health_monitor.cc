// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/health_monitor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace plumbline {
namespace {

constexpr double kMaxSpeed = 40;         // [m/s]
constexpr double kMaxGyroBias = 1;       // [rad/s]
constexpr double kMaxAccelBias = 4;      // [m/s^2]
constexpr double kMaxBlindSeconds = 8;   // an IMU of a phone is off by metres then
constexpr double kMaxVelocityStd = 0.5;  // [m/s]
constexpr double kMaxRejectingSeconds = 2;
/// Of the measurements; an honest gate turns away one in twenty, blurred hand-held video one in
/// five. A state that is wrong soon agrees with a part of the points again, which it moved.
constexpr double kMaxRejectedShare = 0.4;
constexpr double kMaxTurningStd = 3;  // [m/s]
constexpr int kMinGated = 4;
constexpr double kRejectionMemory = 0.7;  // [s]
constexpr double kMaxImuGapSeconds = 2;   // a hand has turned by any angle then
constexpr double kWarnSeconds = 0.5;
constexpr double kWarnFlawSeconds = 0.02;  // of the IMU
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
  if (const int gated = step.accepted + step.rejected; gated >= kMinGated)
    rejected_share_ += (1 - std::exp(-dt / kRejectionMemory)) *
                       (static_cast<double>(step.rejected) / gated - rejected_share_);
  const bool rejecting = rejected_share_ > kMaxRejectedShare;
  rejecting_s_ = rejecting ? rejecting_s_ + dt : std::max(rejecting_s_ - dt, 0.0);
  if (step.nis_dof > 0) nis_ratio_ += 0.05 * (std::min(step.nis / step.nis_dof, 10.0) - nis_ratio_);

  const InertialState& inertial = state.inertial();
  if (!state.finite())
    return {.lost = true, .message = "the filter's numbers are no longer finite"};
  const double speed = inertial.velocity_in_world.norm();
  if (speed > kMaxSpeed)
    return {.lost = true, .message = Sentence("the velocity has run away to %.0f m/s", speed)};
  if (inertial.gyro_bias.norm() > kMaxGyroBias || inertial.accel_bias.norm() > kMaxAccelBias) {
    return {.lost = true,
            .message = Sentence("the biases have run away to %.2f rad/s and %.1f m/s^2",
                                inertial.gyro_bias.norm(), inertial.accel_bias.norm())};
  }
  if (step.imu_gap_s > kMaxImuGapSeconds) {
    return {.lost = true,
            .message = Sentence("the IMU gave no readings for %.1f s, or a clock was set forward",
                                step.imu_gap_s)};
  }
  const double spread = std::sqrt(state.covariance().diagonal().segment<3>(kXiV).maxCoeff());
  // A camera that turns in place cannot be started anew either.
  const double too_uncertain = step.without_depth > 0 ? kMaxTurningStd : kMaxVelocityStd;
  if (blind_s_ > kMaxBlindSeconds && spread > too_uncertain) {
    return {.lost = true,
            .message = Sentence("no point could be used for %.1f s; the IMU alone is too uncertain",
                                blind_s_)};
  }
  if (rejecting_s_ > kMaxRejectingSeconds) {
    return {.lost = true,
            .disagrees = true,
            .message = Sentence("for %.1f s too many points disagreed with the state: the IMU, its "
                                "calibration, a clock or the tracks are wrong",
                                rejecting_s_)};
  }
  if (step.imu_gap_s > kWarnFlawSeconds)
    return {.message = Sentence("the IMU gave no readings for %.2f s", step.imu_gap_s)};
  if (step.imu_saturated_s > 0)
    return {.message = Sentence("the IMU was saturated for %.3f s", step.imu_saturated_s)};
  if (dt > kWarnSeconds) return {.message = Sentence("no image came for %.2f s", dt)};
  if (blind_s_ > kWarnSeconds && step.without_depth > 0) {
    return {.message = Sentence("for %.1f s no point shows parallax, as where a camera only turns: "
                                "the IMU alone",
                                blind_s_)};
  }
  if (blind_s_ > kWarnSeconds)
    return {.message = Sentence("no point could be used for %.1f s: the IMU alone", blind_s_)};
  if (rejecting_s_ > kWarnSeconds)
    return {.message = Sentence("for %.1f s many points disagreed with the state", rejecting_s_)};
  if (nis_ratio_ > kHighNis) {
    return {.message =
                Sentence("innovations are %.1f times what they should be: the noise of pixels "
                         "or IMU is stated too small",
                         nis_ratio_)};
  }
  return {};
}

}  // namespace plumbline
