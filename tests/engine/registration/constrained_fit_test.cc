// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/constrained_fit.h"

#include <numbers>

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/geometry/gravity.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

constexpr FreeMotion kMotions[] = {FreeMotion::kAzimuth, FreeMotion::kAzimuthAndHorizontal,
                                   FreeMotion::kAzimuthAndTranslation, FreeMotion::kRigid};

Eigen::Vector3d Gaussian(Random& random) {
  return {random.Gaussian(), random.Gaussian(), random.Gaussian()};
}

Eigen::Isometry3d UprightPose(const Eigen::Vector3d& up, double azimuth,
                              const Eigen::Vector3d& translation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = UprightFrame(-up).WorldFromObjectRotation(azimuth);
  pose.translation() = translation;
  return pose;
}

std::vector<PointPair> Pairs(const Eigen::Isometry3d& truth, int count, double noise,
                             Random& random) {
  std::vector<PointPair> pairs;
  for (int i = 0; i < count; ++i) {
    PointPair pair;
    pair.in_model = Gaussian(random);
    pair.in_scan = truth * pair.in_model + noise * Gaussian(random);
    pair.normal_in_scan = Gaussian(random).normalized();
    pair.weight = random.Uniform(0.1, 2);
    pairs.push_back(pair);
  }
  return pairs;
}

/// A pose that differs from `truth` only in what is free.
Eigen::Isometry3d Moved(const Eigen::Isometry3d& truth, const Eigen::Vector3d& up,
                        FreeMotion motion, Random& random) {
  Eigen::Isometry3d moved = truth;
  moved.linear() = Eigen::AngleAxisd(random.Uniform(-3, 3), up) * truth.linear();
  if (motion == FreeMotion::kAzimuth) return moved;
  Eigen::Vector3d shift = Gaussian(random);
  if (motion == FreeMotion::kAzimuthAndHorizontal) shift -= up.dot(shift) * up;
  moved.translation() += shift;
  return moved;
}

double SumOfSquares(const std::vector<PointPair>& pairs, const Eigen::Isometry3d& pose) {
  double sum = 0;
  for (const PointPair& pair : pairs) {
    sum += pair.weight * (pose * pair.in_model - pair.in_scan).squaredNorm();
  }
  return sum;
}

TEST(ConstrainedPose, FindsExactPairsInOneStepForAnyGravity) {
  for (std::uint32_t i = 0; i < 400; ++i) {
    Random random({.seed = 7, .frame = i});
    const FreeMotion motion = kMotions[i % 4];
    const Eigen::Vector3d up = Gaussian(random).normalized();
    const Eigen::Isometry3d truth = UprightPose(up, random.Uniform(-3, 3), Gaussian(random));
    ConstrainedPose pose(Moved(truth, up, motion, random), up, motion);
    ASSERT_TRUE(pose.FitPoints(Pairs(truth, 20, 0, random)).ok());
    EXPECT_THAT(pose.scan_from_model(), IsometryNear(truth, 1e-6, 1e-9));
  }
}

TEST(ConstrainedPose, FindsExactPairsAlongNormals) {
  for (std::uint32_t i = 0; i < 100; ++i) {
    Random random({.seed = 8, .frame = i});
    const FreeMotion motion = kMotions[i % 4];
    const Eigen::Vector3d up = Gaussian(random).normalized();
    const Eigen::Isometry3d truth = UprightPose(up, random.Uniform(-3, 3), Gaussian(random));
    Eigen::Isometry3d start = truth;
    start.linear() = Eigen::AngleAxisd(0.3, up) * truth.linear();
    ConstrainedPose pose(start, up, motion);
    const auto pairs = Pairs(truth, 40, 0, random);
    for (int step = 0; step < 12; ++step) pose.StepPlanes(pairs);
    EXPECT_THAT(pose.scan_from_model(), IsometryNear(truth, 1e-6, 1e-6));
  }
}

TEST(ConstrainedPose, KeepsUprightExactlyThroughAThousandNoisySteps) {
  for (const FreeMotion motion : {FreeMotion::kAzimuth, FreeMotion::kAzimuthAndHorizontal,
                                  FreeMotion::kAzimuthAndTranslation}) {
    Random random({.seed = 9});
    const Eigen::Vector3d up = Gaussian(random).normalized();
    const Eigen::Isometry3d truth = UprightPose(up, 1, Gaussian(random));
    ConstrainedPose pose(truth, up, motion);
    for (int i = 0; i < 1000; ++i) {
      const auto pairs = Pairs(truth, 10, 0.5, random);
      if (i % 2 == 0) {
        pose.StepPlanes(pairs);
      } else {
        ASSERT_TRUE(pose.FitPoints(pairs).ok());
      }
    }
    EXPECT_LE(UprightFrame(-up).Tilt(pose.scan_from_model().linear()), 1e-9);
    const Eigen::Vector3d moved = pose.scan_from_model().translation() - truth.translation();
    if (motion == FreeMotion::kAzimuth) {
      EXPECT_EQ(moved.norm(), 0);
    }
    if (motion == FreeMotion::kAzimuthAndHorizontal) {
      EXPECT_LE(std::abs(moved.dot(up)), 1e-11);
    }
  }
}

TEST(ConstrainedPose, IsTheLeastSquaresSolutionAmongItsNeighbours) {
  for (std::uint32_t i = 0; i < 80; ++i) {
    Random random({.seed = 10, .frame = i});
    const FreeMotion motion = kMotions[i % 4];
    const Eigen::Vector3d up = Gaussian(random).normalized();
    const Eigen::Isometry3d truth = UprightPose(up, 0.5, Gaussian(random));
    const auto pairs = Pairs(truth, 15, 0.2, random);
    ConstrainedPose pose(truth, up, motion);
    ASSERT_TRUE(pose.FitPoints(pairs).ok());
    const double least = SumOfSquares(pairs, pose.scan_from_model());
    for (int k = 0; k < 50; ++k) {
      Eigen::Isometry3d other = pose.scan_from_model();
      Eigen::Vector3d shift = 1e-3 * Gaussian(random);
      Eigen::Vector3d turn = 1e-3 * Gaussian(random);
      if (motion != FreeMotion::kRigid) turn = up.dot(turn) * up;
      if (motion == FreeMotion::kAzimuthAndHorizontal) shift -= up.dot(shift) * up;
      if (motion == FreeMotion::kAzimuth) shift.setZero();
      other.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * other.linear();
      other.translation() += shift;
      EXPECT_GE(SumOfSquares(pairs, other), least);
    }
  }
}

TEST(ConstrainedPose, SaysThatPairsOnOneVerticalLineShowNoTurn) {
  const Eigen::Vector3d up(0, 0, 1);
  ConstrainedPose pose(Eigen::Isometry3d::Identity(), up, FreeMotion::kAzimuthAndTranslation);
  std::vector<PointPair> pairs(5);
  for (int i = 0; i < 5; ++i) {
    pairs[static_cast<std::size_t>(i)].in_model = {0, 0, 0.1 * i};
    pairs[static_cast<std::size_t>(i)].in_scan = {1, 2, 0.1 * i};
  }
  const Status status = pose.FitPoints(pairs);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kDegenerate);
  EXPECT_THAT(pose.scan_from_model(), IsometryNear(Eigen::Isometry3d::Identity(), 0.0, 0.0));
}

// 2000 repetitions: the mean of the normalised squared error is its degrees of freedom to 3
// standard deviations, sqrt(2 * dof / 2000) * 3.
TEST(ConstrainedPose, CovarianceIsThatOfTheErrors) {
  for (const FreeMotion motion : {FreeMotion::kAzimuthAndTranslation, FreeMotion::kRigid}) {
    constexpr int kRepetitions = 2000;
    constexpr double kSigma_m = 0.005;
    const int dof = DegreesOfFreedom(motion);
    const Eigen::Vector3d up = Eigen::Vector3d(0.3, -0.5, 0.8).normalized();
    const Eigen::Isometry3d truth = UprightPose(up, 0.7, {1, 2, 3});
    double sum = 0;
    for (std::uint32_t i = 0; i < kRepetitions; ++i) {
      Random random({.seed = 11, .frame = i});
      auto pairs = Pairs(truth, 60, 0, random);
      for (PointPair& pair : pairs) {
        pair.weight = 1;
        pair.in_scan += kSigma_m * random.Gaussian() * pair.normal_in_scan;
      }
      ConstrainedPose pose(truth, up, motion);
      for (int k = 0; k < 5; ++k) pose.StepPlanes(pairs);
      Eigen::Matrix<double, 6, 1> error;
      const Eigen::AngleAxisd turn(
          Eigen::Matrix3d(pose.scan_from_model().linear() * truth.linear().transpose()));
      error << pose.scan_from_model().translation() - truth.translation(),
          turn.angle() * turn.axis();
      Eigen::MatrixXd free = Eigen::MatrixXd::Identity(6, 6);
      if (motion == FreeMotion::kAzimuthAndTranslation) {
        free = Eigen::MatrixXd::Zero(4, 6);
        free.topLeftCorner<3, 3>().setIdentity();
        free.bottomRightCorner<1, 3>() = up.transpose();
      }
      const Eigen::MatrixXd covariance =
          free * pose.PlaneCovariance(pairs, kSigma_m) * free.transpose();
      const Eigen::VectorXd seen = free * error;
      sum += seen.dot(covariance.ldlt().solve(seen));
    }
    EXPECT_NEAR(sum / kRepetitions, dof, 3 * std::sqrt(2.0 * dof / kRepetitions));
  }
}

}  // namespace
}  // namespace plumbline
