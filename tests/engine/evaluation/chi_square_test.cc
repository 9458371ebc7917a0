// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/chi_square.h"

#include <cmath>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

TEST(ChiSquare, HasItsClosedForms) {
  for (const double x : {0.1, 1.0, 4.0, 20.0}) {
    EXPECT_NEAR(ChiSquareCdf(x, 2), 1 - std::exp(-x / 2), 1e-12);
    EXPECT_NEAR(ChiSquareCdf(x, 4), 1 - std::exp(-x / 2) * (1 + x / 2), 1e-12);
    EXPECT_NEAR(ChiSquareCdf(x, 3),
                std::erf(std::sqrt(x / 2)) - std::sqrt(2 * x / M_PI) * std::exp(-x / 2), 1e-12);
  }
  EXPECT_EQ(ChiSquareCdf(0, 4), 0);
  EXPECT_EQ(ChiSquareCdf(-1, 1), 0);
}

TEST(ChiSquare, HasThePublishedQuantiles) {
  // Tables of the 5 % and 95 % points.
  EXPECT_NEAR(ChiSquareQuantile(0.95, 1), 3.8415, 1e-4);
  EXPECT_NEAR(ChiSquareQuantile(0.95, 4), 9.4877, 1e-4);
  EXPECT_NEAR(ChiSquareQuantile(0.05, 10), 3.9403, 1e-4);
  EXPECT_NEAR(ChiSquareQuantile(0.95, 100), 124.342, 1e-3);
}

TEST(ChiSquare, SurvivesManyDegreesOfFreedom) {
  // Nearly Gaussian: mean n, variance 2n.
  EXPECT_NEAR(ChiSquareQuantile(0.975, 4000), 4000 + 1.96 * std::sqrt(8000.0), 5);
}

}  // namespace
}  // namespace plumbline
