// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/start_refinement.h"

#include <gtest/gtest.h>

#include "engine/geometry/angles.h"
#include "engine/vio/rotation.h"
#include "tests/support/vio_simulator.h"

namespace plumbline {
namespace {

/// Three seconds in motion, and what a guess of their start is made of.
struct StartCase {
  explicit StartCase(VioSimulation simulation)
      : recording(Simulate(simulation)), readings(recording.imu) {
    for (const ImuSample& sample : recording.samples) readings.Add(sample);
    for (std::size_t k = 0; k < recording.images.size(); k += 2)
      images.push_back(recording.images[k]);
    const ReferenceState& first = recording.truth.front();
    truth.stamp_ns = first.stamp_ns + Nanoseconds(recording.imu.time_offset_s);
    truth.world_from_body = first.world_from_body.linear();
    truth.velocity_in_world = first.velocity_in_world;
    truth.gyro_bias = first.gyro_bias;
    truth.accel_bias = first.accel_bias;
  }

  /// Off by a tilt, a factor on the velocity, and both biases.
  InertialState Guess(double velocity_factor, double tilt_deg) const {
    InertialState guess = truth;
    const Eigen::Matrix3d tilt = RotationExp({tilt_deg * kRadPerDeg, 0, 0});
    guess.world_from_body = tilt * truth.world_from_body;
    guess.velocity_in_world = velocity_factor * (tilt * truth.velocity_in_world);
    guess.gyro_bias.setZero();
    guess.accel_bias.setZero();
    return guess;
  }

  std::optional<RefinedStart> Refine(const InertialState& guess) const {
    return RefineStart(recording.camera, recording.imu, readings, images, guess, {});
  }

  SimulatedRecording recording;
  ImuBuffer readings;
  std::vector<TrackedImage> images;
  InertialState truth;
};

double TiltBetween(const InertialState& a, const InertialState& b) {
  const double cosine = a.world_from_body.row(2).dot(b.world_from_body.row(2));
  return std::acos(std::min(1.0, cosine)) * kDegPerRad;
}

TEST(StartRefinement, FindsTheTruthWithoutNoise) {
  VioSimulation simulation{.seconds = 3, .pixel_noise_px = 0, .imu_noise = 0, .seed = 4};
  // The accelerometer's bias has a prior of 0.1 m/s^2 about zero, which draws: none to be found.
  simulation.accel_bias.setZero();
  const StartCase start(simulation);
  const auto refined = start.Refine(start.Guess(0.6, 3));
  ASSERT_TRUE(refined.has_value());
  EXPECT_LT((refined->inertial.velocity_in_world - start.truth.velocity_in_world).norm(), 0.01);
  EXPECT_LT((refined->inertial.gyro_bias - start.truth.gyro_bias).norm(), 2e-4);
  EXPECT_LT(TiltBetween(refined->inertial, start.truth), 0.1);
}

TEST(StartRefinement, EndsInOnePlaceWhereverItBegins) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const StartCase start({.seconds = 3, .seed = seed});
    const auto reference = start.Refine(start.Guess(1, 0));
    ASSERT_TRUE(reference.has_value()) << seed;
    for (const double factor : {0.5, 0.7, 1.3}) {
      const auto refined = start.Refine(start.Guess(factor, 2));
      ASSERT_TRUE(refined.has_value()) << seed;
      EXPECT_LT(
          (refined->inertial.velocity_in_world - reference->inertial.velocity_in_world).norm(),
          0.02 * start.truth.velocity_in_world.norm())
          << seed << " from " << factor;
    }
    const double off =
        (reference->inertial.velocity_in_world - start.truth.velocity_in_world).norm();
    EXPECT_LT(off, 5 * reference->velocity_std_m_s + 0.02 * start.truth.velocity_in_world.norm())
        << seed;
    EXPECT_LT(TiltBetween(reference->inertial, start.truth), 1) << seed;
  }
}

TEST(StartRefinement, MismatchesDoNotMoveIt) {
  StartCase start({.seconds = 3, .seed = 6});
  const auto before = start.Refine(start.Guess(0.7, 1));
  ASSERT_TRUE(before.has_value());
  // Every fifth track slides over the picture.
  int moved = 0;
  for (std::size_t k = 0; k < start.images.size(); ++k) {
    for (TrackedPoint& point : start.images[k].points) {
      if (point.id % 5 != 0) continue;
      point.pixel += Eigen::Vector2d(4, -3) * static_cast<double>(k);
      ++moved;
    }
  }
  ASSERT_GT(moved, 100);
  const auto after = start.Refine(start.Guess(0.7, 1));
  ASSERT_TRUE(after.has_value());
  EXPECT_LT(after->tracks, before->tracks);
  EXPECT_LT((after->inertial.velocity_in_world - before->inertial.velocity_in_world).norm(),
            0.05 * start.truth.velocity_in_world.norm());
}

TEST(StartRefinement, FollowsTheRowsOfARollingShutter) {
  VioSimulation simulation{
      .seconds = 3, .pixel_noise_px = 0, .imu_noise = 0, .rolling_shutter_s = 0.03, .seed = 7};
  simulation.accel_bias.setZero();
  StartCase start(simulation);
  const auto error = [&] {
    const auto refined = start.Refine(start.Guess(0.7, 1));
    EXPECT_TRUE(refined.has_value());
    return refined ? (refined->inertial.velocity_in_world - start.truth.velocity_in_world).norm()
                   : 0.0;
  };
  const double told = error();
  start.recording.camera.rolling_shutter_s = 0;
  EXPECT_LT(told, 0.01);
  EXPECT_GT(error(), 3 * told);
}

TEST(StartRefinement, NeedsPointsThatLive) {
  StartCase start({.seconds = 3, .seed = 8});
  for (TrackedImage& image : start.images) image.points.resize(10);
  for (std::size_t k = 0; k < start.images.size(); ++k) {
    for (TrackedPoint& point : start.images[k].points)
      point.id += 1000 * static_cast<std::int64_t>(k / 3);
  }
  EXPECT_FALSE(start.Refine(start.Guess(1, 0)).has_value());
  start.images.resize(1);
  EXPECT_FALSE(start.Refine(start.Guess(1, 0)).has_value());
}

}  // namespace
}  // namespace plumbline
