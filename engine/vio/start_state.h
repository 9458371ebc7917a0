// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include <Eigen/Core>

#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"
#include "engine/vio/filter_state.h"
#include "engine/vio/vio_options.h"

namespace plumbline {

/// How uncertain a start is: standard deviations of each axis.
struct StartSpread {
  double tilt_rad = 0.01, yaw_rad = 1e-4;
  double velocity_m_s = 0.05, position_m = 1e-4;
  double gyro_bias_rad_s = 0.002, accel_bias_m_s2 = 0.05;
};

/// A filter's state whose errors of rotation, velocity and position are independent. The
/// calibration's spread comes from `options`. @param camera  With `body_from_cam`.
FilterState MakeStart(const InertialState& inertial, const Camera& camera, double time_offset_s,
                      const StartSpread& spread, const VioOptions& options);

/// What a rest says of the state at its end.
struct RestStart {
  InertialState inertial;
  StartSpread spread;
  Eigen::Vector3d force;  ///< Mean specific force, in the body's axes [m/s^2].
};

/// The start at the end of a rest: upright by the mean specific force, the gyro's bias the mean
/// angular velocity, no velocity. Heading and position are those of the identity. The spread of the
/// tilt is wide: UpdateWithForce tells tilt and accelerometer bias apart as far as that goes.
/// @param samples  Of the rest; the last one's stamp is that of the state.
/// Errors: kDegenerate where the mean specific force is not about gravity: the body is not at rest,
/// or the unit is wrong.
Result<RestStart> StartFromRest(std::span<const ImuSample> samples, const ImuCalibration& imu,
                                const VioOptions& options);

/// Updates a state with a specific force that was measured without acceleration. Of the bias it
/// tells the part along gravity; tilt and the rest of it become as correlated as they are.
void UpdateWithForce(const Eigen::Vector3d& force_in_body, double gravity_m_s2, FilterState& state);

/// The rotation that makes this specific force point up, with heading zero.
Eigen::Matrix3d UprightRotation(const Eigen::Vector3d& specific_force_in_body);

}  // namespace plumbline
