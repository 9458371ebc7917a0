// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/gravity.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "engine/base/check.h"
#include "engine/base/random.h"
#include "engine/geometry/random_vector.h"

namespace plumbline {
namespace {

std::vector<Eigen::Vector3d> ManyGravities() {
  std::vector<Eigen::Vector3d> all;
  for (int axis = 0; axis < 3; ++axis) {
    all.push_back(Eigen::Vector3d::Unit(axis));
    all.push_back(-Eigen::Vector3d::Unit(axis));
  }
  Random random({.seed = 7});
  for (int i = 0; i < 1000; ++i) {
    all.push_back(GaussianVector<3>(random).normalized());
  }
  return all;
}

TEST(UprightFrame, IsARotationThatKeepsTheObjectUpright) {
  Random random({.seed = 8});
  for (const Eigen::Vector3d& gravity : ManyGravities()) {
    const UprightFrame frame(gravity);
    const Eigen::Matrix3d rotation = frame.WorldFromObjectRotation(random.Uniform(-3, 3));
    EXPECT_TRUE((rotation * rotation.transpose()).isIdentity(1e-12));
    EXPECT_NEAR(rotation.determinant(), 1.0, 1e-12);
    EXPECT_LT((rotation.col(2) + gravity).norm(), 1e-12);
    EXPECT_LT(frame.Tilt(rotation), 1e-9);
  }
}

// As by the library's remainder, to the last bit.
TEST(WrapAngle, IsTheRemainder) {
  constexpr double kPi = std::numbers::pi;
  const auto expect_remainder = [](double angle) {
    const double wrapped = std::remainder(angle, 2 * kPi);
    EXPECT_EQ(WrapAngle(angle), wrapped <= -kPi ? wrapped + 2 * kPi : wrapped) << angle;
  };
  Random random({.seed = 11});
  for (int i = 0; i < 20000; ++i) expect_remainder(random.Uniform(-15, 15));
  for (int half_turns = -6; half_turns <= 6; ++half_turns) {
    const double angle = half_turns * kPi;
    for (const double beside : {-1.0, 0.0, 1.0})
      expect_remainder(std::nextafter(angle, 99 * beside));
    expect_remainder(angle);
  }
  EXPECT_EQ(WrapAngle(-kPi), kPi);
  EXPECT_TRUE(std::isnan(WrapAngle(std::nan(""))));
}

TEST(UprightFrame, AzimuthIsTheInverseOfTheRotation) {
  Random random({.seed = 9});
  for (const Eigen::Vector3d& gravity : ManyGravities()) {
    const UprightFrame frame(gravity);
    const double azimuth = random.Uniform(-std::numbers::pi, std::numbers::pi);
    EXPECT_NEAR(WrapAngle(frame.Azimuth(frame.WorldFromObjectRotation(azimuth)) - azimuth), 0.0,
                1e-12);
  }
}

TEST(UprightFrame, AzimuthTurnsRightHandedAboutUpSoThePapersThetaIsItsNegative) {
  Random random({.seed = 10});
  for (const Eigen::Vector3d& gravity : ManyGravities()) {
    const UprightFrame frame(gravity);
    const double azimuth = random.Uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Matrix3d about_up =
        Eigen::AngleAxisd(azimuth, frame.up_in_world()).toRotationMatrix() *
        frame.upright_rotation();
    // Rodrigues' formula of the paper about gamma = gravity with theta = -azimuth.
    const Eigen::Matrix3d about_gravity =
        Eigen::AngleAxisd(-azimuth, gravity).toRotationMatrix() * frame.upright_rotation();
    EXPECT_TRUE(frame.WorldFromObjectRotation(azimuth).isApprox(about_up, 1e-12));
    EXPECT_TRUE(frame.WorldFromObjectRotation(azimuth).isApprox(about_gravity, 1e-12));
  }
}

TEST(UprightFrame, EqualsAtan2InAWorldWithZUp) {
  const UprightFrame frame(Eigen::Vector3d(0, 0, -9.81));
  const Eigen::Matrix3d rotation = frame.WorldFromObjectRotation(0.7);
  EXPECT_NEAR(std::atan2(rotation(1, 0), rotation(0, 0)), 0.7, 1e-15);
}

TEST(UprightFrame, RefusesAGravityWithoutDirection) {
  EXPECT_THROW(UprightFrame{Eigen::Vector3d::Zero()}, ContractError);
}

}  // namespace
}  // namespace plumbline
