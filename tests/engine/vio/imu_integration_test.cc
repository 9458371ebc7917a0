// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/imu_integration.h"

#include <gtest/gtest.h>

#include "engine/vio/rotation.h"

namespace plumbline {
namespace {

using InertialError = Eigen::Matrix<double, kInertialSize, 1>;

InertialState SomeState() {
  InertialState state;
  state.world_from_body = RotationExp({0.4, -0.3, 1.1});
  state.velocity_in_world << 0.8, -1.2, 0.3;
  state.position_in_world << 2, -3, 1.5;
  state.gyro_bias << 0.02, -0.01, 0.03;
  state.accel_bias << 0.1, -0.2, 0.15;
  return state;
}

ImuSegment SomeSegment(double seconds) {
  return {0, Nanoseconds(seconds), {0.9, -1.4, 0.6}, {1.5, -2.5, 9}, 1};
}

/// The state with an error, as imu_integration.h defines it.
InertialState WithError(const InertialState& state, const InertialError& error) {
  const Eigen::Vector3d phi = error.segment<3>(kPhi);
  const Eigen::Matrix3d turn = RotationExp(phi), jacobian = LeftJacobian(phi);
  InertialState moved = state;
  moved.world_from_body = turn * state.world_from_body;
  moved.velocity_in_world = turn * state.velocity_in_world + jacobian * error.segment<3>(kXiV);
  moved.position_in_world = turn * state.position_in_world + jacobian * error.segment<3>(kXiP);
  moved.gyro_bias += error.segment<3>(kGyroBias);
  moved.accel_bias += error.segment<3>(kAccelBias);
  return moved;
}

InertialError ErrorBetween(const InertialState& state, const InertialState& moved) {
  const Eigen::Matrix3d turn = moved.world_from_body * state.world_from_body.transpose();
  const Eigen::Vector3d phi = RotationLog(turn);
  const Eigen::Matrix3d inverse = LeftJacobian(phi).inverse();
  InertialError error;
  error << phi, inverse * (moved.velocity_in_world - turn * state.velocity_in_world),
      inverse * (moved.position_in_world - turn * state.position_in_world),
      moved.gyro_bias - state.gyro_bias, moved.accel_bias - state.accel_bias;
  return error;
}

TEST(ImuIntegration, TransitionIsTheDerivativeOfTheStep) {
  constexpr double kStep = 1e-6;
  for (const double seconds : {0.005, 0.02}) {
    const ImuSegment segment = SomeSegment(seconds);
    const Integration step = Integrate(SomeState(), std::span(&segment, 1), {});
    for (int i = 0; i < kInertialSize; ++i) {
      const InertialError d = kStep * InertialError::Unit(i);
      const auto moved = [&](const InertialError& error) {
        return ErrorBetween(
            step.state, Integrate(WithError(SomeState(), error), std::span(&segment, 1), {}).state);
      };
      const InertialError numeric = (moved(d) - moved(-d)) / (2 * kStep);
      // The derivatives by the gyro's bias leave the third order of a small turn out: its square
      // (2 rad/s) over 8, times dt^2 and a force of 10 m/s^2.
      const double left_out = 10 * seconds * seconds * std::pow(2 * seconds, 2) / 8;
      EXPECT_LT((numeric - step.transition.col(i)).norm(), 1e-8 + left_out) << "column " << i;
    }
  }
}

TEST(ImuIntegration, HeadingAndPositionAreCarriedAlongWhateverTheState) {
  std::vector<ImuSegment> segments;
  for (int k = 0; k < 40; ++k) {
    segments.push_back({k * 5'000'000,
                        (k + 1) * 5'000'000,
                        {std::sin(0.3 * k), 0.5, -std::cos(0.2 * k)},
                        {std::cos(0.1 * k), 1, 9.5},
                        1});
  }
  const Integration all = Integrate(SomeState(), segments, {});
  Eigen::Matrix<double, kInertialSize, 4> free = Eigen::Matrix<double, kInertialSize, 4>::Zero();
  free(kPhi + 2, 0) = 1;
  free.block<3, 3>(kXiP, 1).setIdentity();
  EXPECT_LT((all.transition * free - free).norm(), 1e-12);
}

TEST(ImuIntegration, AConstantTurnAndForceAreExactWhateverTheStep) {
  const ImuSegment whole = SomeSegment(0.2);
  std::vector<ImuSegment> parts;
  for (int k = 0; k < 20; ++k) {
    ImuSegment part = whole;
    part.begin_ns = k * 10'000'000;
    part.end_ns = (k + 1) * 10'000'000;
    parts.push_back(part);
  }
  const InertialState a = Integrate(SomeState(), std::span(&whole, 1), {}).state;
  const InertialState b = Integrate(SomeState(), parts, {}).state;
  EXPECT_LT(ErrorBetween(a, b).norm(), 1e-12);
}

TEST(ImuIntegration, NoiseGrowsAsARandomWalk) {
  IntegrationNoise noise;
  noise.gyro_density = 1e-3;
  InertialState still;
  std::vector<ImuSegment> segments;
  for (int k = 0; k < 100; ++k)
    segments.push_back({k * 10'000'000, (k + 1) * 10'000'000, {0, 0, 0}, {0, 0, 9.81}, 1});
  const Integration all = Integrate(still, segments, noise);
  EXPECT_NEAR(all.noise(kPhi, kPhi), 1e-6, 1e-12);  // density^2 * 1 s
}

TEST(ImuBuffer, InterpolatesAndCutsGapsShort) {
  ImuCalibration calibration;
  ImuBuffer buffer(calibration);
  for (int k = 0; k <= 10; ++k) buffer.Add({k * 5'000'000, {1.0 * k, 0, 0}, {0, 0, 9.81}});
  EXPECT_FALSE(buffer.Add({5'000'000, {0, 0, 0}, {0, 0, 9.81}}));  // does not rise
  buffer.Add({150'000'000, {0, 0, 0}, {0, 0, 9.81}});
  EXPECT_DOUBLE_EQ(buffer.At(7'500'000)->angular_velocity_rad_s.x(), 1.5);
  const auto segments = buffer.Between(2'500'000, 12'500'000);
  ASSERT_EQ(segments.size(), 3u);
  EXPECT_EQ(segments.front().begin_ns, 2'500'000);
  EXPECT_EQ(segments.back().end_ns, 12'500'000);
  EXPECT_DOUBLE_EQ(segments[0].angular_velocity_rad_s.x(), 0.75);
  const auto gap = buffer.Between(40'000'000, 150'000'000);
  EXPECT_EQ(gap.size(), 12u);  // two readings, then 100 ms in steps of 10
  EXPECT_EQ(gap[0].noise_factor, 1);
  EXPECT_GT(gap.back().noise_factor, 10);
}

}  // namespace
}  // namespace plumbline
