// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/assignment.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <set>

#include <gtest/gtest.h>

#include "engine/base/random.h"

namespace plumbline {
namespace {

constexpr double kForbidden = std::numeric_limits<double>::infinity();

struct Total {
  int pairs = 0;
  double cost = 0;
  bool BetterThan(const Total& other) const {
    return pairs != other.pairs ? pairs > other.pairs : cost < other.cost;
  }
};

/// All ways to assign.
Total BestByTrying(const Eigen::MatrixXd& cost) {
  std::vector<int> columns(std::max(cost.rows(), cost.cols()));
  std::iota(columns.begin(), columns.end(), 0);
  Total best{-1, 0};
  do {
    Total total;
    for (int i = 0; i < cost.rows(); ++i) {
      if (columns[i] >= cost.cols() || cost(i, columns[i]) == kForbidden) continue;
      ++total.pairs;
      total.cost += cost(i, columns[i]);
    }
    if (total.BetterThan(best)) best = total;
  } while (std::next_permutation(columns.begin(), columns.end()));
  return best;
}

TEST(AssignOneToOne, IsAsGoodAsTryingEverything) {
  Random random({.seed = 1});
  for (int trial = 0; trial < 300; ++trial) {
    Eigen::MatrixXd cost(random.Index(6), random.Index(6) + 1);
    for (int i = 0; i < cost.size(); ++i) {
      cost.data()[i] = random.Uniform() < 0.4 ? kForbidden : random.Uniform(0, 0.5);
    }
    const std::vector<std::optional<int>> assigned = AssignOneToOne(cost);
    Total total;
    std::set<int> used;
    for (int i = 0; i < cost.rows(); ++i) {
      if (!assigned[i]) continue;
      EXPECT_TRUE(used.insert(*assigned[i]).second);
      ASSERT_LT(cost(i, *assigned[i]), kForbidden);
      ++total.pairs;
      total.cost += cost(i, *assigned[i]);
    }
    const Total best = BestByTrying(cost);
    EXPECT_EQ(total.pairs, best.pairs);
    EXPECT_NEAR(total.cost, best.cost, 1e-12);
  }
}

TEST(AssignOneToOne, DoesNotTakeTheNearestFirst) {
  Eigen::MatrixXd cost(2, 2);
  cost << 0.1, 0.2, 0.15, kForbidden;  // taking (0, 0) would leave row 1 alone
  EXPECT_EQ(AssignOneToOne(cost), (std::vector<std::optional<int>>{1, 0}));
}

TEST(AssignOneToOne, HandlesEmptyAndForbiddenMatrices) {
  EXPECT_TRUE(AssignOneToOne(Eigen::MatrixXd(0, 3)).empty());
  EXPECT_EQ(AssignOneToOne(Eigen::MatrixXd(2, 0)), (std::vector<std::optional<int>>{{}, {}}));
  EXPECT_EQ(AssignOneToOne(Eigen::MatrixXd::Constant(1, 2, kForbidden)),
            (std::vector<std::optional<int>>{{}}));
}

}  // namespace
}  // namespace plumbline
