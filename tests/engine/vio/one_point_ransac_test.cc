// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/one_point_ransac.h"
#include "engine/geometry/random_vector.h"

#include <gtest/gtest.h>

#include "engine/base/random.h"

namespace plumbline {
namespace {

/// A state of three numbers, known to 10, that forty measurements of two rows each see.
struct Seen {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd(80, 3);
  Eigen::VectorXd residual = Eigen::VectorXd(80);
  Eigen::MatrixXd projected;
};

Seen Measure(int wrong, bool alike) {
  Random random({.seed = 7});
  Seen seen;
  const Eigen::Vector3d error(12, -9, 0.001), other(-14, 7, 0.001);
  for (int i = 0; i < 40; ++i) {
    // Each measurement tells the first two, the third hardly.
    seen.jacobian.middleRows<2>(2 * i) << 1, random.Uniform(-0.02, 0.02), random.Uniform(-1, 1),
        random.Uniform(-0.02, 0.02), 1, random.Uniform(-1, 1);
    Eigen::Vector3d truth = error;
    if (i < wrong)
      truth = alike ? other : Eigen::Vector3d(random.Uniform(-30, 30), random.Uniform(-30, 30), 0);
    seen.residual.segment<2>(2 * i) =
        seen.jacobian.middleRows<2>(2 * i) * truth + 0.7 * GaussianVector<2>(random);
  }
  const Eigen::Vector3d variance(100, 100, 1e-6);
  seen.projected = seen.jacobian * variance.asDiagonal() * seen.jacobian.transpose();
  return seen;
}

TEST(OnePointConsensus, TakesTheRightOnesWhereEachAloneWouldPassItsGate) {
  for (const bool alike : {false, true}) {
    const int wrong = 16;
    const Seen seen = Measure(wrong, alike);
    const std::vector<bool> agrees = OnePointConsensus(seen.residual, seen.projected, 9);
    int right = 0;
    for (int i = 0; i < 40; ++i) {
      // By itself each is likely: the state's own uncertainty covers it.
      if (alike && i < wrong) {
        const double nis = seen.residual.segment<2>(2 * i).squaredNorm() / 101;
        EXPECT_LT(nis, 5.99);
      }
      const bool taken = agrees[static_cast<std::size_t>(i)];
      EXPECT_FALSE(i < wrong && taken) << i;
      right += i >= wrong && taken;
    }
    EXPECT_GE(right, 22) << "of 24";
  }
}

TEST(OnePointConsensus, OfNothingIsNothing) {
  EXPECT_TRUE(OnePointConsensus(Eigen::VectorXd(0), Eigen::MatrixXd(0, 0), 6).empty());
}

}  // namespace
}  // namespace plumbline
