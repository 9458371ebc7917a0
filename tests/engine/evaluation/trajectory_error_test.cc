// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/trajectory_error.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/base/random.h"

namespace plumbline {
namespace {

Eigen::Isometry3d Pose(double yaw, const Eigen::Vector3d& place) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = place;
  return pose;
}

/// A helix at 10 Hz and 1 m/s along x.
std::vector<TimedPose> Helix() {
  std::vector<TimedPose> poses;
  for (int k = 0; k <= 100; ++k) {
    const double t = 0.1 * k;
    poses.push_back({k * 100'000'000LL, Pose(0.2 * t, {t, std::sin(t), 0.3 * std::cos(t)}), {}});
  }
  return poses;
}

std::vector<TimedPose> Moved(std::vector<TimedPose> poses, const Eigen::Isometry3d& move,
                             double scale) {
  for (TimedPose& pose : poses) {
    pose.world_from_sensor = move * pose.world_from_sensor;
    pose.world_from_sensor.translation() *= scale;
  }
  return poses;
}

Eigen::Isometry3d Turn(double angle, const Eigen::Vector3d& axis) {
  Eigen::Isometry3d move(Eigen::AngleAxisd(angle, axis.normalized()));
  move.translation() << 3, -2, 1;
  return move;
}

TrajectoryErrors Compare(const std::vector<TimedPose>& estimate, TrajectoryAlignment align) {
  const auto errors = CompareTrajectories(estimate, Helix(), {.align = align});
  EXPECT_TRUE(errors.ok());
  return *errors;
}

TEST(TrajectoryError, EachAlignmentTakesOutItsOwnFreedom) {
  const auto turned = Moved(Helix(), Turn(0.8, {0, 0, 1}), 1);
  EXPECT_NEAR(Compare(turned, TrajectoryAlignment::kYaw).ate_m, 0, 1e-9);
  EXPECT_NEAR(Compare(turned, TrajectoryAlignment::kYaw).ate_rad, 0, 1e-7);
  EXPECT_GT(Compare(turned, TrajectoryAlignment::kNone).ate_m, 1);
  const auto tilted = Moved(Helix(), Turn(0.5, {1, 2, -1}), 1);
  EXPECT_NEAR(Compare(tilted, TrajectoryAlignment::kSe3).ate_m, 0, 1e-9);
  EXPECT_GT(Compare(tilted, TrajectoryAlignment::kYaw).ate_m, 0.1);
  const auto larger = Moved(Helix(), Turn(0.5, {1, 2, -1}), 1.25);
  EXPECT_NEAR(Compare(larger, TrajectoryAlignment::kSim3).ate_m, 0, 1e-9);
  EXPECT_NEAR(Compare(larger, TrajectoryAlignment::kSe3).scale, 0.8, 1e-9);
}

TEST(TrajectoryError, TiltIsTheAngleBetweenTheDirectionsOfDown) {
  std::vector<TimedPose> tilted = Helix();
  for (TimedPose& pose : tilted) {
    pose.world_from_sensor.linear() =
        Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitY()) * pose.world_from_sensor.linear();
  }
  const TrajectoryErrors errors = Compare(tilted, TrajectoryAlignment::kYaw);
  EXPECT_NEAR(errors.tilt_rad, 0.05, 1e-9);
  EXPECT_NEAR(errors.ate_rad, 0.05, 1e-9);
  EXPECT_NEAR(errors.ate_m, 0, 1e-9);
}

TEST(TrajectoryError, AnErrorOfOneAxisIsItsRootMeanSquare) {
  std::vector<TimedPose> shaken = Helix();
  for (std::size_t k = 0; k < shaken.size(); ++k)
    shaken[k].world_from_sensor.translation().z() += k % 2 == 0 ? 0.02 : -0.02;
  const TrajectoryErrors errors = Compare(shaken, TrajectoryAlignment::kNone);
  EXPECT_NEAR(errors.ate_m, 0.02, 1e-12);
  // Poses a second apart are ten steps apart: both are off alike.
  EXPECT_NEAR(errors.by_time[0].translation_m, 0, 1e-9);
  EXPECT_EQ(errors.by_time[0].pairs, 91);
}

TEST(TrajectoryError, RelativeErrorGrowsWithTheSpanOfADrift) {
  std::vector<TimedPose> drifting = Helix();
  for (std::size_t k = 0; k < drifting.size(); ++k)
    drifting[k].world_from_sensor.translation().x() += 0.01 * 0.1 * static_cast<double>(k);
  const TrajectoryErrors errors = Compare(drifting, TrajectoryAlignment::kNone);
  EXPECT_NEAR(errors.by_time[0].translation_m, 0.01, 1e-9);
  EXPECT_NEAR(errors.by_time[1].translation_m, 0.05, 1e-9);
}

TEST(TrajectoryError, StampsBetweenReferencesAreInterpolatedAndOthersNotMatched) {
  std::vector<TimedPose> between;
  for (int k = 0; k < 50; ++k) {
    const std::int64_t stamp = k * 100'000'000LL + 50'000'000;
    const double t = static_cast<double>(stamp) * 1e-9;
    between.push_back({stamp, Pose(0.2 * t, {t, std::sin(t), 0.3 * std::cos(t)}), {}});
  }
  between.push_back({99'000'000'000LL, Eigen::Isometry3d::Identity(), {}});
  const TrajectoryErrors errors = Compare(between, TrajectoryAlignment::kNone);
  EXPECT_EQ(errors.matched, 50);
  EXPECT_LT(errors.ate_m, 0.0015);  // the chord of 0.1 s: an eighth of its square
}

TEST(TrajectoryError, NeesIsSixForErrorsOfTheirCovariance) {
  std::vector<TimedPose> estimate = Helix();
  Random random({3});
  for (std::size_t k = 0; k < estimate.size(); ++k) {
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << 0.02, 0.03, 0.01, 0.002, 0.001, 0.003;
    estimate[k].covariance = sigma.cwiseAbs2().asDiagonal().toDenseMatrix();
    if (k == 0) continue;  // the first pose is the gauge
    Eigen::Vector3d turn;
    for (int i = 0; i < 3; ++i) {
      estimate[k].world_from_sensor.translation()(i) += sigma(i) * random.Gaussian();
      turn(i) = sigma(3 + i) * random.Gaussian();
    }
    estimate[k].world_from_sensor.linear() =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()) * estimate[k].world_from_sensor.linear();
  }
  const TrajectoryErrors errors = Compare(estimate, TrajectoryAlignment::kYaw);
  ASSERT_TRUE(errors.nees.has_value());
  EXPECT_NEAR(*errors.nees, 6, 4 * std::sqrt(12.0 / 100));  // of 100 means of chi-squared
}

TEST(TrajectoryError, RefusesTooFewMatches) {
  std::vector<TimedPose> two = Helix();
  two.resize(2);
  EXPECT_FALSE(CompareTrajectories(two, Helix(), {}).ok());
}

}  // namespace
}  // namespace plumbline
