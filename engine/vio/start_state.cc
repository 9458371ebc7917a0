// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/start_state.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "engine/base/check.h"
#include "engine/geometry/angles.h"
#include "engine/vio/lens.h"
#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

/// Rest is never perfect: what a hand or a table adds to the mean specific force of a second.
constexpr double kRestAcceleration = 0.05;  // [m/s^2]
constexpr double kRestVelocity = 0.03;      // [m/s]
constexpr double kRestGyroBias = 0.005;     // [rad/s]
/// A mean specific force farther than this from gravity's length is no rest.
constexpr double kMaxForceError = 2.0;  // [m/s^2]

double Square(double x) { return x * x; }

}  // namespace

FilterState MakeStart(const InertialState& inertial, const Camera& camera, double time_offset_s,
                      const StartSpread& spread, const VioOptions& options) {
  using Covariance = Eigen::Matrix<double, kCalibratedSize, kCalibratedSize>;
  Covariance plain = Covariance::Zero();
  auto diagonal = plain.diagonal();
  diagonal.segment<2>(kPhi).setConstant(Square(spread.tilt_rad));
  diagonal(kPhi + 2) = Square(spread.yaw_rad);
  diagonal.segment<3>(kXiV).setConstant(Square(spread.velocity_m_s));
  diagonal.segment<3>(kXiP).setConstant(Square(spread.position_m));
  diagonal.segment<3>(kGyroBias).setConstant(Square(spread.gyro_bias_rad_s));
  diagonal.segment<3>(kAccelBias).setConstant(Square(spread.accel_bias_m_s2));
  if (options.estimate_extrinsics) {
    diagonal.segment<3>(kCamRotation)
        .setConstant(Square(options.extrinsic_rotation_std_deg * kRadPerDeg));
    diagonal.segment<3>(kCamTranslation).setConstant(Square(options.extrinsic_translation_std_m));
  }
  if (options.estimate_time_offset) diagonal(kTimeOffset) = Square(options.time_offset_std_s);
  if (options.estimate_intrinsics) {
    diagonal.segment<4>(kLens).setConstant(Square(options.intrinsics_std_px));
    diagonal.segment(kLens + 4, std::min<Eigen::Index>(4, std::ssize(camera.distortion)))
        .setConstant(Square(options.distortion_std));
  }
  if (options.estimate_rolling_shutter)
    diagonal(kLens + kReadOut) = Square(options.rolling_shutter_std_s);
  // xi = plain error - phi x value
  Covariance to_error = Covariance::Identity();
  to_error.block<3, 3>(kXiV, kPhi) = Hat(inertial.velocity_in_world);
  to_error.block<3, 3>(kXiP, kPhi) = Hat(inertial.position_in_world);
  return FilterState(inertial, *camera.body_from_cam, time_offset_s, LensOf(camera),
                     to_error * plain * to_error.transpose());
}

Eigen::Matrix3d UprightRotation(const Eigen::Vector3d& specific_force_in_body) {
  const Eigen::Vector3d up = specific_force_in_body.normalized();
  // Heading zero: the body's x axis made horizontal is the world's, or its y axis where x is steep.
  const Eigen::Vector3d axis =
      std::abs(up.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d x = (axis - axis.dot(up) * up).normalized();
  Eigen::Matrix3d world_from_body;
  world_from_body << x.transpose(), up.cross(x).transpose(), up.transpose();
  return world_from_body;
}

Result<RestStart> StartFromRest(std::span<const ImuSample> samples, const ImuCalibration& imu,
                                const VioOptions& options) {
  PLB_CHECK(!samples.empty());
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), turn = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : samples) {
    force += sample.specific_force_m_s2;
    turn += sample.angular_velocity_rad_s;
  }
  force /= static_cast<double>(samples.size());
  turn /= static_cast<double>(samples.size());
  const double off = std::abs(force.norm() - imu.gravity_m_s2);
  if (off > kMaxForceError) {
    char text[160];
    std::snprintf(text, sizeof(text),
                  "the mean specific force at rest is %.2f m/s^2 instead of %.2f; check the unit "
                  "and the scale of the accelerometer",
                  force.norm(), imu.gravity_m_s2);
    return Error{ErrorCode::kDegenerate, text};
  }
  InertialState inertial;
  inertial.stamp_ns = samples.back().stamp_ns;
  inertial.world_from_body = UprightRotation(force);
  inertial.gyro_bias = turn;
  StartSpread spread;
  spread.tilt_rad = 0.5;
  spread.velocity_m_s = kRestVelocity;
  spread.gyro_bias_rad_s = kRestGyroBias;
  // What is off in gravity's length is about what is off in every axis.
  spread.accel_bias_m_s2 = std::max(options.start_accel_bias_std_m_s2, 1.5 * off);
  return RestStart{inertial, spread, force};
}

void UpdateWithForce(const Eigen::Vector3d& force_in_body, double gravity_m_s2,
                     FilterState& state) {
  // force = R' up g + bias
  const Eigen::Vector3d up(0, 0, gravity_m_s2);
  const Eigen::Matrix3d body_from_world = state.inertial().world_from_body.transpose();
  Eigen::MatrixXd jacobian(3, 6);
  jacobian << body_from_world * Hat(up), Eigen::Matrix3d::Identity();
  const RowRange rows[] = {{kPhi, 3}, {kAccelBias, 3}};
  const Eigen::Vector3d residual =
      force_in_body - body_from_world * up - state.inertial().accel_bias;
  PLB_CHECK(state.Update(jacobian / kRestAcceleration, rows, residual / kRestAcceleration,
                         NoiseOf::kRest));
}

}  // namespace plumbline
