// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/imu_integration.h"

#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

/// Derivative by `turn` of LeftJacobian(turn) * v, up to second order of the small turn of one
/// sample.
Eigen::Matrix3d LeftJacobianByTurn(const Eigen::Vector3d& turn, const Eigen::Vector3d& v) {
  return -0.5 * Hat(v) - (Hat(turn) * Hat(v) + Hat(turn.cross(v))) / 6;
}

/// Likewise of SecondIntegral(turn) * v.
Eigen::Matrix3d SecondIntegralByTurn(const Eigen::Vector3d& turn, const Eigen::Vector3d& v) {
  return -Hat(v) / 6 - (Hat(turn) * Hat(v) + Hat(turn.cross(v))) / 24;
}

}  // namespace

void IntegrateStep(const ImuSegment& segment, const IntegrationNoise& noise,
                   Integration& integration) {
  const double dt = segment.seconds();
  InertialState& s = integration.state;
  const Eigen::Vector3d turn = (segment.angular_velocity_rad_s - s.gyro_bias) * dt;
  const Eigen::Vector3d force = segment.specific_force_m_s2 - s.accel_bias;
  const Eigen::Vector3d gravity(0, 0, -noise.gravity_m_s2);
  const Eigen::Matrix3d R = s.world_from_body;
  const Eigen::Matrix3d first = LeftJacobian(turn), second = SecondIntegral(turn);

  s.position_in_world +=
      dt * s.velocity_in_world + dt * dt * (0.5 * gravity + R * (second * force));
  s.velocity_in_world += dt * (gravity + R * (first * force));
  s.world_from_body = R * RotationExp(turn);
  s.stamp_ns = segment.end_ns;

  const Eigen::Matrix3d turned = dt * R * first;
  InertialMatrix step = InertialMatrix::Identity();
  step.block<3, 3>(kXiV, kPhi) = dt * Hat(gravity);
  step.block<3, 3>(kXiP, kPhi) = 0.5 * dt * dt * Hat(gravity);
  step.block<3, 3>(kXiP, kXiV) = dt * Eigen::Matrix3d::Identity();
  step.block<3, 3>(kPhi, kGyroBias) = -turned;
  step.block<3, 3>(kXiV, kGyroBias) =
      -Hat(s.velocity_in_world) * turned - dt * dt * R * LeftJacobianByTurn(turn, force);
  step.block<3, 3>(kXiP, kGyroBias) =
      -Hat(s.position_in_world) * turned - dt * dt * dt * R * SecondIntegralByTurn(turn, force);
  step.block<3, 3>(kXiV, kAccelBias) = -turned;
  step.block<3, 3>(kXiP, kAccelBias) = -dt * dt * R * second;

  // White noise acts on a step as an error of the bias that lasts for the step.
  const double factor = segment.noise_factor * segment.noise_factor;
  const double gyro = factor * noise.gyro_density * noise.gyro_density / dt;
  const double accel = factor * noise.accel_density * noise.accel_density / dt;
  const auto by_gyro = step.block<9, 3>(kPhi, kGyroBias);
  const auto by_accel = step.block<9, 3>(kPhi, kAccelBias);
  integration.transition = (step * integration.transition).eval();
  integration.noise = (step * integration.noise * step.transpose()).eval();
  integration.noise.topLeftCorner<9, 9>() +=
      gyro * by_gyro * by_gyro.transpose() + accel * by_accel * by_accel.transpose();
  integration.noise.diagonal().segment<3>(kGyroBias).array() +=
      noise.gyro_walk * noise.gyro_walk * dt;
  integration.noise.diagonal().segment<3>(kAccelBias).array() +=
      noise.accel_walk * noise.accel_walk * dt;
}

Integration Integrate(const InertialState& start, std::span<const ImuSegment> segments,
                      const IntegrationNoise& noise) {
  Integration integration;
  integration.state = start;
  for (const ImuSegment& segment : segments) IntegrateStep(segment, noise, integration);
  integration.state.world_from_body = Orthonormal(integration.state.world_from_body);
  return integration;
}

}  // namespace plumbline
