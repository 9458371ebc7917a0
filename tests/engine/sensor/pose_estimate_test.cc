// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/pose_estimate.h"

#include <gmock/gmock.h>

#include "tests/support/test_data.h"

namespace plumbline {
namespace {

Eigen::Isometry3d SomePose() {
  Eigen::Isometry3d pose(Eigen::AngleAxisd(1.2, Eigen::Vector3d(1, -2, 0.5).normalized()));
  pose.translation() << 3, -1, 2;
  return pose;
}

TEST(PosePerturbation, IsTranslationThenRotationAlongTheAxesOfTheWorld) {
  PosePerturbation error;
  error << 0.1, 0.2, 0.3, 0, 0, 0.5;
  const Eigen::Isometry3d moved = Perturbed(SomePose(), error);
  EXPECT_LT((moved.translation() - Eigen::Vector3d(3.1, -0.8, 2.3)).norm(), 1e-12);
  const Eigen::Matrix3d yaw = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitZ()).matrix();
  EXPECT_LT((moved.linear() - yaw * SomePose().linear()).norm(), 1e-12);
}

TEST(PosePerturbation, BetweenTwoPosesLeadsFromOneToTheOther) {
  PosePerturbation error;
  error << -0.3, 0.02, 1, 0.4, -0.7, 0.2;
  EXPECT_LT((PerturbationBetween(SomePose(), Perturbed(SomePose(), error)) - error).norm(), 1e-12);
  EXPECT_EQ(PerturbationBetween(SomePose(), SomePose()).head<3>(), Eigen::Vector3d::Zero());
  EXPECT_THAT(Perturbed(SomePose(), PosePerturbation::Zero()), IsometryNear(SomePose(), 0.0, 0.0));
}

}  // namespace
}  // namespace plumbline
