// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/point_tree.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "engine/base/random.h"

namespace plumbline {
namespace {

std::vector<Eigen::Vector3f> Cloud(int count) {
  Random random({.seed = 3});
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1));
  }
  return points;
}

TEST(PointTree, FindsWhatTheExhaustiveSearchFinds) {
  const auto points = Cloud(2000);
  const PointTree tree(points);
  Random random({.seed = 4});
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3f query(random.Uniform(-1.5, 1.5), random.Uniform(-1.5, 1.5),
                                random.Uniform(-1.5, 1.5));
    std::vector<std::pair<float, int>> order;
    std::vector<int> within;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const float squared = (points[k] - query).squaredNorm();
      order.emplace_back(squared, static_cast<int>(k));
      if (squared < 0.09f) within.push_back(static_cast<int>(k));
    }
    std::sort(order.begin(), order.end());
    EXPECT_EQ(tree.Nearest(query).index, order[0].second);
    const auto nearest = tree.Nearest(query, 5);
    ASSERT_EQ(nearest.size(), 5u);
    for (std::size_t k = 0; k < 5; ++k) EXPECT_EQ(nearest[k].index, order[k].second);
    EXPECT_EQ(tree.Within(query, 0.3f), within);
  }
}

TEST(PointTree, WithoutPointsFindsNothing) {
  const PointTree tree({});
  EXPECT_EQ(tree.Nearest(Eigen::Vector3f(0, 0, 0)).index, -1);
  EXPECT_TRUE(tree.Nearest(Eigen::Vector3f(0, 0, 0), 3).empty());
  EXPECT_TRUE(tree.Within(Eigen::Vector3f(0, 0, 0), 1).empty());
  EXPECT_EQ(PointTree(Cloud(2)).Nearest(Eigen::Vector3f(0, 0, 0), 3).size(), 2u);
}

}  // namespace
}  // namespace plumbline
