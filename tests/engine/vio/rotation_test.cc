// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/rotation.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

const Eigen::Vector3d kTurns[] = {
    {0, 0, 0}, {1e-5, -2e-5, 1e-5}, {0.006, 0.004, -0.005}, {0.05, -0.08, 0.02}, {1, -0.7, 0.4}};

TEST(Rotation, LogarithmUndoesTheExponential) {
  for (const Eigen::Vector3d& turn : kTurns)
    EXPECT_LT((RotationLog(RotationExp(turn)) - turn).norm(), 1e-12);
}

TEST(Rotation, LeftJacobianIsTheDerivativeOfTheExponential) {
  constexpr double kStep = 1e-6;
  for (const Eigen::Vector3d& turn : kTurns) {
    Eigen::Matrix3d numeric;
    for (int i = 0; i < 3; ++i) {
      const Eigen::Vector3d d = kStep * Eigen::Vector3d::Unit(i);
      numeric.col(i) = (RotationLog(RotationExp(turn + d) * RotationExp(-turn)) -
                        RotationLog(RotationExp(turn - d) * RotationExp(-turn))) /
                       (2 * kStep);
    }
    EXPECT_LT((numeric - LeftJacobian(turn)).norm(), 1e-8);  // central differences
  }
}

TEST(Rotation, SecondIntegralIsThatOfTheTurningDirection) {
  constexpr int kSteps = 2000;
  for (const Eigen::Vector3d& turn : kTurns) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (int k = 0; k < kSteps; ++k) {
      const double s = (k + 0.5) / kSteps;
      sum += (1 - s) * RotationExp(s * turn) / kSteps;
    }
    EXPECT_LT((sum - SecondIntegral(turn)).norm(), 1e-6);  // the midpoint rule
  }
}

}  // namespace
}  // namespace plumbline
