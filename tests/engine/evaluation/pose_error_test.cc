// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/pose_error.h"

#include <numbers>

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/geometry/random_vector.h"
#include "tests/engine/evaluation/test_scene.h"

namespace plumbline {
namespace {

constexpr double kPi = std::numbers::pi;

Eigen::Vector3d RandomDirection(Random& random) { return GaussianVector<3>(random).normalized(); }

TEST(ComparePoses, SplitsAKnownErrorIntoItsParts) {
  const UprightFrame upright({0, 0, -1});
  const Eigen::Isometry3d truth = UprightPose(1, 2, 0, 30);
  const Eigen::Isometry3d estimate = UprightPose(1.03, 2, 0.04, 25);
  const PoseError error = ComparePoses(estimate, truth, {}, upright);
  EXPECT_NEAR(error.translation_m, 0.05, 1e-12);
  EXPECT_NEAR(error.height_m, 0.04, 1e-12);
  EXPECT_NEAR(error.rotation_rad, 5 * kPi / 180, 1e-12);
  EXPECT_NEAR(*error.azimuth_rad, -5 * kPi / 180, 1e-12);
  EXPECT_NEAR(error.tilt_rad, 0, 1e-12);
}

TEST(ComparePoses, SeesAPureTilt) {
  const UprightFrame upright({0, 0, -1});
  Eigen::Isometry3d estimate = UprightPose(0, 0, 0, 0);
  estimate.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const PoseError error = ComparePoses(estimate, UprightPose(0, 0, 0, 0), {}, upright);
  EXPECT_NEAR(error.tilt_rad, 0.1, 1e-12);
  EXPECT_NEAR(error.rotation_rad, 0.1, 1e-12);
  EXPECT_NEAR(*error.azimuth_rad, 0, 1e-12);
}

TEST(ComparePoses, RotationIsTheNormOfTheLogarithm) {
  Random random({.seed = 2});
  const UprightFrame upright({0, 0, -1});
  for (int trial = 0; trial < 1000; ++trial) {
    Eigen::Isometry3d truth = Eigen::Isometry3d::Identity(), estimate = truth;
    truth.linear() =
        Eigen::AngleAxisd(random.Uniform(-3, 3), RandomDirection(random)).toRotationMatrix();
    const double angle = trial % 2 == 0 ? random.Uniform(0, kPi) : 1e-7 * random.Uniform();
    estimate.linear() =
        truth.linear() * Eigen::AngleAxisd(angle, RandomDirection(random)).toRotationMatrix();
    EXPECT_NEAR(ComparePoses(estimate, truth, {}, upright).rotation_rad, angle, 1e-12);
  }
}

TEST(ComparePoses, TakesTheBestOfTheSymmetryGroup) {
  const UprightFrame upright({0, 0, -1});
  for (const int order : {2, 3, 4, 6}) {
    for (int k = 0; k < order; ++k) {
      const Eigen::Isometry3d estimate = UprightPose(0, 0, 0, 20 + 360.0 * k / order + 4);
      const PoseError error =
          ComparePoses(estimate, UprightPose(0, 0, 0, 20), {.order = order}, upright);
      EXPECT_NEAR(error.rotation_rad, 4 * kPi / 180, 1e-12);
      EXPECT_NEAR(*error.azimuth_rad, 4 * kPi / 180, 1e-12);
    }
  }
}

TEST(ComparePoses, HandlesSymmetryAboutAnotherAxis) {
  const UprightFrame upright({0, 0, -1});
  const Symmetry about_x{{1, 0, 0}, 2};
  Eigen::Isometry3d estimate = UprightPose(0, 0, 0, 33);
  estimate.linear() =
      estimate.linear() * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  const PoseError error = ComparePoses(estimate, UprightPose(0, 0, 0, 30), about_x, upright);
  EXPECT_NEAR(error.rotation_rad, 3 * kPi / 180, 1e-12);
  EXPECT_NEAR(error.tilt_rad, 0, 1e-12);
}

TEST(ComparePoses, CountsOnlyTheTiltOfARoundObject) {
  const UprightFrame upright({0, 0, -1});
  Eigen::Isometry3d estimate = UprightPose(0, 0, 0, 77);
  EXPECT_NEAR(ComparePoses(estimate, UprightPose(0, 0, 0, 0), {.order = 0}, upright).rotation_rad,
              0, 1e-12);
  estimate.linear() =
      Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitY()).toRotationMatrix() * estimate.linear();
  const PoseError error = ComparePoses(estimate, UprightPose(0, 0, 0, 0), {.order = 0}, upright);
  EXPECT_NEAR(error.rotation_rad, 0.2, 1e-12);
  EXPECT_NEAR(error.tilt_rad, 0.2, 1e-12);
  EXPECT_FALSE(error.azimuth_rad.has_value());
}

TEST(ComparePoses, DoesNotDependOnTheDirectionOfGravity) {
  Random random({.seed = 3});
  const UprightFrame z_up({0, 0, -1});
  const Eigen::Isometry3d truth = UprightPose(1, 2, 0, 30),
                          estimate = UprightPose(1.1, 2.2, 0.05, 47);
  const PoseError expected = ComparePoses(estimate, truth, {}, z_up);
  for (int trial = 0; trial < 100; ++trial) {
    Eigen::Isometry3d turn = Eigen::Isometry3d::Identity();
    turn.linear() =
        Eigen::AngleAxisd(random.Uniform(-3, 3), RandomDirection(random)).toRotationMatrix();
    turn.translation() = 5 * RandomDirection(random);
    const UprightFrame upright(turn.linear() * Eigen::Vector3d(0, 0, -1));
    const PoseError error = ComparePoses(turn * estimate, turn * truth, {}, upright);
    EXPECT_NEAR(error.translation_m, expected.translation_m, 1e-12);
    EXPECT_NEAR(error.rotation_rad, expected.rotation_rad, 1e-12);
    EXPECT_NEAR(*error.azimuth_rad, *expected.azimuth_rad, 1e-12);
    EXPECT_NEAR(error.tilt_rad, 0, 1e-12);
    EXPECT_NEAR(error.height_m, expected.height_m, 1e-12);
  }
}

}  // namespace
}  // namespace plumbline
