// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/sensor/imu.h"
#include "engine/vio/imu_buffer.h"

namespace plumbline {

/// Where the body is, how it moves, and what its IMU adds. `world` has z up.
struct InertialState {
  std::int64_t stamp_ns = 0;  ///< On the IMU's clock.
  Eigen::Matrix3d world_from_body = Eigen::Matrix3d::Identity();
  Eigen::Vector3d velocity_in_world{0, 0, 0};  ///< [m/s]
  Eigen::Vector3d position_in_world{0, 0, 0};  ///< Of the body [m].
  Eigen::Vector3d gyro_bias{0, 0, 0};          ///< [rad/s]
  Eigen::Vector3d accel_bias{0, 0, 0};         ///< [m/s^2]

  Eigen::Isometry3d pose() const {
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.linear() = world_from_body;
    result.translation() = position_in_world;
    return result;
  }
};

/// First rows of the parts of an InertialState's error (docs/algorithms/vio.md): the rotation
/// vector phi on the side of the world, then velocity and position WITHOUT what phi moves, then
/// biases:
///   R = Exp(phi) R^   v = Exp(phi) v^ + J xi_v   p = Exp(phi) p^ + J xi_p, J the left Jacobian.
inline constexpr int kPhi = 0, kXiV = 3, kXiP = 6, kGyroBias = 9, kAccelBias = 12,
                     kInertialSize = 15;
using InertialMatrix = Eigen::Matrix<double, kInertialSize, kInertialSize>;

struct IntegrationNoise {
  double gyro_density = 0, accel_density = 0;  ///< [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)]
  double gyro_walk = 0, accel_walk = 0;        ///< [rad/s^2/sqrt(Hz)], [m/s^3/sqrt(Hz)]
  double gravity_m_s2 = 9.81;
};

/// A state carried forward, and how its error was carried along.
struct Integration {
  InertialState state;
  InertialMatrix transition = InertialMatrix::Identity();
  InertialMatrix noise = InertialMatrix::Zero();  ///< Covariance that was added.
};

/// One step with constant angular velocity and specific force, biases not yet removed. Extends
/// `integration`. @param noise_factor  On the densities of this step.
void IntegrateStep(const ImuSegment& segment, const IntegrationNoise& noise,
                   Integration& integration);

/// All of `segments` from `start` on.
Integration Integrate(const InertialState& start, std::span<const ImuSegment> segments,
                      const IntegrationNoise& noise);

}  // namespace plumbline
