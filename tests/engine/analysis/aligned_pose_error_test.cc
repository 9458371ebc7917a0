// SPDX-License-Identifier: Apache-2.0
#include "engine/analysis/aligned_pose_error.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "engine/evaluation/trajectory_error.h"
#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {
namespace {

constexpr int kPoses = 60;
const Eigen::Vector3d kUp(0, 0, 1);

std::vector<Eigen::Isometry3d> Walk() {
  std::vector<Eigen::Isometry3d> walk;
  for (int i = 0; i < kPoses; ++i) {
    const double a = 0.07 * i;
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translation() << 2 * std::sin(a), 3 * (1 - std::cos(a)), 1.5 + 0.1 * std::sin(3 * a);
    pose.linear() = Eigen::AngleAxisd(a, kUp).toRotationMatrix();
    walk.push_back(pose);
  }
  return walk;
}

/// What a step adds, as standard deviations of a motion about the camera.
PosePerturbation StepStd() {
  PosePerturbation deviation;
  deviation << 0.002, 0.003, 0.001, 0.0002, 0.0003, 0.0008;
  return deviation;
}

std::vector<std::optional<ToldPose>> Told(const std::vector<Eigen::Isometry3d>& walk) {
  std::vector<std::optional<ToldPose>> told;
  PoseCovariance covariance = PoseCovariance::Zero();
  for (std::size_t i = 0; i < walk.size(); ++i) {
    if (i > 0) covariance = MovedBy(walk[i].translation() - walk[i - 1].translation(), covariance);
    covariance += PoseCovariance(StepStd().cwiseAbs2().asDiagonal());
    told.push_back(ToldPose{walk[i].translation(), covariance});
  }
  return told;
}

/// The walk as somebody sees it whose every step errs, and what follows with it.
std::vector<Eigen::Isometry3d> Drifted(const std::vector<Eigen::Isometry3d>& walk,
                                       std::mt19937& random) {
  std::normal_distribution<double> normal;
  Eigen::Isometry3d drift = Eigen::Isometry3d::Identity();  // world_from_true_world
  std::vector<Eigen::Isometry3d> drifted;
  for (const Eigen::Isometry3d& pose : walk) {
    PosePerturbation error;
    for (int k = 0; k < 6; ++k) error[k] = StepStd()[k] * normal(random);
    const Eigen::Isometry3d before = drift * pose;
    drift = Perturbed(before, error) * pose.inverse();
    drifted.push_back(drift * pose);
  }
  return drifted;
}

std::vector<TimedPose> Timed(const std::vector<Eigen::Isometry3d>& walk) {
  std::vector<TimedPose> timed;
  for (std::size_t i = 0; i < walk.size(); ++i)
    timed.push_back({static_cast<std::int64_t>(i) * 100'000'000, walk[i], std::nullopt});
  return timed;
}

double PositionVariance(const PoseCovariance& covariance) {
  return covariance.topLeftCorner(3, 3).trace();
}

TEST(ErrorsAfterAlignment, AreThoseOfManyWalksThatWereAligned) {
  const std::vector<Eigen::Isometry3d> walk = Walk();
  const auto predicted = ErrorsAfterAlignment(Told(walk), kUp);
  std::mt19937 random(4);
  constexpr int kWalks = 1500;
  std::vector<PoseCovariance> found(walk.size(), PoseCovariance::Zero());
  for (int k = 0; k < kWalks; ++k) {
    const std::vector<Eigen::Isometry3d> drifted = Drifted(walk, random);
    const auto errors = CompareTrajectories(Timed(drifted), Timed(walk), {});
    ASSERT_TRUE(errors.ok());
    const Eigen::Isometry3d truth_from_drifted(errors->reference_from_estimate);
    for (std::size_t i = 0; i < walk.size(); ++i) {
      const PosePerturbation off = PerturbationBetween(walk[i], truth_from_drifted * drifted[i]);
      found[i] += off * off.transpose() / kWalks;
    }
  }
  for (const std::size_t i : {0u, 7u, 25u, 44u, 59u}) {
    SCOPED_TRACE(i);
    // Every direction: the errors as the prediction's own units would have variance 1.
    const PosePerturbation scale = predicted[i].diagonal().cwiseSqrt();
    const PoseCovariance apart = scale.cwiseInverse().asDiagonal() * (found[i] - predicted[i]) *
                                 scale.cwiseInverse().asDiagonal();
    EXPECT_LT(apart.cwiseAbs().maxCoeff(), 0.15);
  }
  EXPECT_LT(PositionVariance(predicted[25]), 0.5 * PositionVariance(predicted[59]))
      << "the middle errs least";
}

TEST(ErrorsAfterAlignment, AreNoneWhereAllPosesShareOne) {
  std::vector<std::optional<ToldPose>> told;
  PoseCovariance covariance = PoseCovariance::Zero();  // a shift, and a turn about up
  covariance.topLeftCorner<3, 3>() = 0.01 * Eigen::Matrix3d::Identity();
  covariance(5, 5) = 0.04;
  const std::vector<Eigen::Isometry3d> walk = Walk();
  for (const Eigen::Isometry3d& pose : walk) {
    told.push_back(ToldPose{pose.translation(),
                            MovedBy(pose.translation() - walk[0].translation(), covariance)});
  }
  told.insert(told.begin(), std::nullopt);
  const auto errors = ErrorsAfterAlignment(told, kUp);
  ASSERT_EQ(errors.size(), told.size());
  for (const PoseCovariance& error : errors) EXPECT_LT(error.cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ErrorsAfterAlignment, OfPosesThatALoopMadeBetterStayWhereTheyAre) {
  const std::vector<Eigen::Isometry3d> walk = Walk();
  auto told = Told(walk);
  for (std::size_t i = 40; i < told.size(); ++i) {
    told[i]->covariance = told[10]->covariance;
    told[i]->covariance(5, 5) *= 3;  // the place is known again, less so the heading
  }
  const auto errors = ErrorsAfterAlignment(told, kUp);
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_GE(EigenOf(errors[i]).values.minCoeff(), -1e-9) << i;
    EXPECT_LE(PositionVariance(errors[i]),
              2 * PositionVariance(told[59]->covariance) + PositionVariance(told[i]->covariance))
        << i;
  }
  EXPECT_GT(errors[30].trace(), errors[59].trace()) << "it had drifted farther";
}

TEST(ErrorsAfterAlignment, OfNoPosesAreNone) {
  EXPECT_TRUE(ErrorsAfterAlignment({}, kUp).empty());
  const std::vector<std::optional<ToldPose>> one = {ToldPose{}};
  EXPECT_TRUE(ErrorsAfterAlignment(one, kUp).front().isZero(1e-9));
}

}  // namespace
}  // namespace plumbline
