// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/symmetric_matrix.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

Eigen::MatrixXd Indefinite() {
  Eigen::MatrixXd matrix(3, 3);
  matrix << 2, -1, 0.5, -1, -3, 0.25, 0.5, 0.25, 1;
  return matrix;
}

Eigen::MatrixXd Definite() { return Indefinite() * Indefinite().transpose(); }

TEST(SymmetricMatrix, IsTheSumOfItsEigenvectors) {
  const auto [values, vectors] = EigenOf(Indefinite());
  EXPECT_LT(values[0], values[1]);
  EXPECT_LT(values[1], values[2]);
  EXPECT_LT((vectors * values.asDiagonal() * vectors.transpose() - Indefinite()).norm(), 1e-12);
  EXPECT_LT((vectors.transpose() * vectors - Eigen::Matrix3d::Identity()).norm(), 1e-12);
}

TEST(SymmetricMatrix, SolvesIndefiniteSystems) {
  const Eigen::Vector3d right(1, -2, 0.5);
  EXPECT_LT((Indefinite() * SolveSymmetric(Indefinite(), right) - right).norm(), 1e-12);
  EXPECT_LT((Indefinite() * InverseOfSymmetric(Indefinite()) - Eigen::Matrix3d::Identity()).norm(),
            1e-12);
}

TEST(Subspace, HoldsTheBestOfItsSteps) {
  Eigen::MatrixXd directions(3, 2);
  directions << 1, 0, 0, 1, 0, 1;
  const Subspace free(directions);
  const Eigen::Vector3d gradient(0.3, -1, 2);
  const Eigen::VectorXd step =
      SolveSymmetric(free.RestrictForm(Definite()), free.RestrictGradient(gradient));
  const Eigen::Vector3d full = free.ExpandStep(step);
  EXPECT_EQ(full.y(), full.z()) << "the second direction moves both by the same";
  const auto cost = [&](const Eigen::Vector3d& x) {
    return 0.5 * x.dot(Definite() * x) - gradient.dot(x);
  };
  for (int k = 0; k < 2; ++k) {
    for (const double by : {-1e-3, 1e-3}) {
      EXPECT_GT(cost(full + by * directions.col(k)), cost(full));
    }
  }
}

TEST(Subspace, GivesLockedDirectionsNoVariance) {
  Eigen::MatrixXd directions = Eigen::MatrixXd::Zero(3, 2);
  directions(0, 0) = directions(2, 1) = 1;
  const Eigen::MatrixXd covariance =
      Subspace(directions).ExpandCovariance(Definite().topLeftCorner(2, 2));
  EXPECT_EQ(covariance(0, 2), Definite()(0, 1));
  EXPECT_EQ(covariance(2, 2), Definite()(1, 1));
  EXPECT_TRUE(covariance.row(1).isZero(0));
  EXPECT_TRUE(covariance.col(1).isZero(0));
}

}  // namespace
}  // namespace plumbline
