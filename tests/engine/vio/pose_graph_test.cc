// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/pose_graph.h"

#include <cmath>

#include <gtest/gtest.h>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

constexpr double kDoubt = 13.3;

Eigen::Matrix4d Covariance(double std_m, double std_rad) {
  return Eigen::Vector4d(std_m * std_m, std_m * std_m, std_m * std_m, std_rad * std_rad)
      .asDiagonal();
}

/// Poses along x, a metre apart.
PoseGraph Chain(int count, double std_m, double std_rad) {
  PoseGraph graph(kDoubt);
  for (int i = 0; i < count; ++i) {
    graph.AddPose({0, Eigen::Vector3d(i, 0, 0)});
    if (i > 0) graph.AddEdge({i - 1, i, {1, 0, 0}, 0, Covariance(std_m, std_rad), false});
  }
  return graph;
}

TEST(PoseGraph, SharesOutWhatALoopSaysByTheVariances) {
  // Steps of variance s^2, a loop of variance t^2 that says d more: the end moves by
  // d 4 s^2 / (4 s^2 + t^2), and the poses before it by equal parts of that.
  const double s = 0.1, t = 0.15, d = 0.2;
  PoseGraph graph = Chain(5, s, 1e-6);
  graph.AddEdge({0, 4, {4 + d, 0, 0}, 0, Covariance(t, 1e-3), false});
  graph.Optimise();
  const double moved = d * 4 * s * s / (4 * s * s + t * t);
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(graph.poses()[static_cast<std::size_t>(i)].position_in_world.x(), i + moved * i / 4,
                1e-6);
  }
}

TEST(PoseGraph, SharesOutATurnAcrossTheWrap) {
  PoseGraph graph(kDoubt);
  for (int i = 0; i < 3; ++i) {
    graph.AddPose({3.1 * (i > 0), {0, 0, 0}});
    if (i > 0)
      graph.AddEdge({i - 1, i, {0, 0, 0}, i == 1 ? 3.1 : 0.0, Covariance(0.1, 0.1), false});
  }
  // 3.1 + 0.2 is -2.98: one turn less, 0.2 more than the steps say.
  graph.AddEdge({0, 2, {0, 0, 0}, 3.3 - 2 * M_PI, Covariance(0.1, 0.001), false});
  graph.Optimise();
  EXPECT_NEAR(graph.poses()[1].yaw_rad, 3.2, 1e-3);
  EXPECT_NEAR(std::remainder(graph.poses()[2].yaw_rad - 3.3, 2 * M_PI), 0, 1e-3);
}

TEST(PoseGraph, KnowsHowUncertainOnePoseIsFromAnother) {
  const double s = 0.02, w = 0.01;
  const PoseGraph graph = Chain(4, s, w);
  // From 1 to 3: two steps' own errors, and the turn at 2 swings the second step sideways.
  const Eigen::Matrix4d relative = graph.RelativeCovariance(1, 3);
  EXPECT_NEAR(relative(0, 0), 2 * s * s, 1e-12);
  EXPECT_NEAR(relative(1, 1), 2 * s * s + w * w, 1e-12);
  EXPECT_NEAR(relative(3, 3), 2 * w * w, 1e-12);
  EXPECT_NEAR(relative(1, 3), w * w, 1e-12);
  // The first pose is certain: from it, the relative covariance is the marginal.
  EXPECT_TRUE(graph.RelativeCovariance(0, 2).isApprox(graph.Marginals()[2], 1e-9));
}

TEST(PoseGraph, WorkGrowsWithLoops) {
  PoseGraph graph = Chain(60, 0.02, 0.01);
  // A chain has no fill: below the diagonal 7, 6, 5 and 4 entries for each pose but the last.
  EXPECT_EQ(graph.Work(), 58 * (49 + 36 + 25 + 16) + (9 + 4 + 1));
  graph.AddEdge({5, 40, {0, 0, 0.2}, 0.3, Covariance(0.05, 0.02), true});
  EXPECT_GT(graph.Work(), 58 * 126 + 14);
  EXPECT_EQ(Chain(1, 0.02, 0.01).Work(), 0);
}

TEST(PoseGraph, MarginalsAreTheBlocksOfTheWholeInverse) {
  PoseGraph graph(kDoubt);
  constexpr int kPoses = 60;
  for (int i = 0; i < kPoses; ++i) {
    graph.AddPose({0.1 * i, {std::cos(0.3 * i), std::sin(0.3 * i), 0.01 * i}});
    if (i > 0) graph.AddEdge({i - 1, i, {0.3, 0, 0.01}, 0.1, Covariance(0.02, 0.01), false});
  }
  for (const auto& [from, to] :
       {std::pair{0, 21}, std::pair{3, 24}, std::pair{5, 59}, std::pair{30, 51}, std::pair{0, 58}})
    graph.AddEdge({from, to, {0, 0, 0.2}, 0.3, Covariance(0.05, 0.02), true});
  const auto marginals = graph.Marginals();
  ASSERT_EQ(marginals.size(), std::size_t{kPoses});
  EXPECT_TRUE(marginals[0].isZero(0));
  // The first pose is certain and its heading is 0: what is known of a pose from there is in the
  // same axes.
  for (int i = 1; i < kPoses; ++i) {
    EXPECT_TRUE(
        graph.RelativeCovariance(0, i).isApprox(marginals[static_cast<std::size_t>(i)], 1e-8))
        << i;
  }
}

TEST(PoseGraph, PosesThatAreTakenOutChangeNothingForTheOthers) {
  PoseGraph graph(kDoubt);
  constexpr int kPoses = 40;
  for (int i = 0; i < kPoses; ++i) {
    graph.AddPose({0.05 * i, {0.9 * std::cos(0.3 * i), std::sin(0.3 * i), 0.01 * i}});
    if (i > 0) {
      const Eigen::Matrix4d covariance = Covariance(0.02 + 0.001 * i, 0.01);
      graph.AddEdge({i - 1, i, {0.3, 0.01 * i, 0.01}, 0.05, covariance, false});
    }
  }
  graph.AddEdge({2, 23, {0, 0, 0.2}, 1.0, Covariance(0.05, 0.02), true});
  graph.AddEdge({10, 39, {0, 0, 0.2}, 1.4, Covariance(0.05, 0.02), true});
  PoseGraph few = graph;
  std::vector<bool> unwanted(kPoses, false);
  for (const int i : {0, 2, 5, 6, 7, 22, 24, 38, 39}) unwanted[static_cast<std::size_t>(i)] = true;
  const std::vector<int> number = few.TakeOut(unwanted);
  ASSERT_EQ(few.poses().size(), std::size_t{kPoses - 6}) << "0, 2 and 39 stay";
  EXPECT_EQ(few.edges().size(), graph.edges().size() - 6);
  EXPECT_EQ(number[4], 4);
  EXPECT_EQ(number[6], -1);
  EXPECT_EQ(number[39], 33);
  graph.Optimise();
  few.Optimise();
  const auto marginals = graph.Marginals(), of_few = few.Marginals();
  for (std::size_t i = 0; i < kPoses; ++i) {
    if (number[i] < 0) continue;
    const auto at = static_cast<std::size_t>(number[i]);
    const GraphPose &one = graph.poses()[i], &other = few.poses()[at];
    // A joined edge is of first order in the turn between its poses.
    EXPECT_LT((one.position_in_world - other.position_in_world).norm(), 2e-3) << i;
    EXPECT_NEAR(one.yaw_rad, other.yaw_rad, 1e-3) << i;
    EXPECT_LT((marginals[i] - of_few[at]).norm(), 0.02 * marginals[i].norm() + 1e-12) << i;
  }
}

/// Twice round a square of 10 m, as odometry has it whose every step turns a little too far.
struct Walk {
  static constexpr int kCount = 81;
  static Eigen::Vector3d At(int i) {
    const int k = i % 40, side = k / 10, along = k % 10;
    const Eigen::Vector3d corner[] = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
    const Eigen::Vector3d ahead[] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    return corner[side] + along * ahead[side];
  }
  explicit Walk(PoseGraph& graph) {
    constexpr double kTurn = 0.2 * kRadPerDeg;
    Eigen::Vector3d position(0, 0, 0);
    drifted.push_back(position);
    graph.AddPose({0, position});
    for (int i = 1; i < kCount; ++i) {
      const Eigen::Vector3d step =
          Eigen::AngleAxisd(kTurn * i, Eigen::Vector3d::UnitZ()) * (At(i) - At(i - 1));
      position += step;
      drifted.push_back(position);
      graph.AddPose({0, position});
      graph.AddEdge({i - 1, i, step, 0, Covariance(0.02, 0.5 * kRadPerDeg), false});
    }
    turn_per_step = kTurn;
  }
  /// What a true match of two poses would say, in the odometry's axes at `from`.
  GraphEdge Match(int from, int to) const {
    GraphEdge edge{from, to, {}, -turn_per_step * (to - from), Covariance(0.02, 0.005), true};
    edge.step =
        Eigen::AngleAxisd(turn_per_step * from, Eigen::Vector3d::UnitZ()) * (At(to) - At(from));
    return edge;
  }
  std::vector<Eigen::Vector3d> drifted;
  double turn_per_step = 0;
};

TEST(PoseGraph, BringsAWalkThatDriftedBackToWhereItWas) {
  PoseGraph graph(kDoubt);
  const Walk walk(graph);
  ASSERT_GT((walk.drifted[80] - walk.drifted[0]).norm(), 1);
  for (const int i : {40, 45, 50, 60, 70, 80}) graph.AddEdge(walk.Match(i - 40, i));
  graph.Optimise();
  EXPECT_LT((graph.poses()[80].position_in_world - graph.poses()[0].position_in_world).norm(),
            0.05);
  for (int i = 0; i < Walk::kCount; ++i) {
    // Heading was never measured against the room but by the loops: what is left bends the square.
    EXPECT_LT((graph.poses()[static_cast<std::size_t>(i)].position_in_world - Walk::At(i)).norm(),
              0.3)
        << i;
  }
  for (const GraphEdge& edge : graph.edges()) EXPECT_GT(graph.TrustIn(edge), 0.5);
}

TEST(PoseGraph, GivesAFalseLoopUp) {
  PoseGraph with(kDoubt), without(kDoubt);
  const Walk walk(with);
  const Walk same(without);
  for (const int i : {40, 45, 50, 60, 70, 80}) {
    with.AddEdge(walk.Match(i - 40, i));
    without.AddEdge(walk.Match(i - 40, i));
  }
  GraphEdge lie = walk.Match(5, 65);  // another side of the square, that looks the same
  lie.step.setZero();
  lie.yaw_rad = 0.3;
  with.AddEdge(lie);
  with.Optimise();
  without.Optimise();
  EXPECT_LT(with.TrustIn(with.edges().back()), 0.05);
  for (std::size_t i = 0; i < Walk::kCount; ++i) {
    EXPECT_LT((with.poses()[i].position_in_world - without.poses()[i].position_in_world).norm(),
              0.02)
        << i;
  }
}

TEST(PoseGraph, GivesTheSameTwice) {
  PoseGraph a(kDoubt), b(kDoubt);
  const Walk walk(a);
  const Walk again(b);
  for (PoseGraph* graph : {&a, &b}) {
    graph->AddEdge(walk.Match(10, 50));
    graph->Optimise();
  }
  for (std::size_t i = 0; i < Walk::kCount; ++i)
    EXPECT_EQ(a.poses()[i].position_in_world, b.poses()[i].position_in_world);
}

}  // namespace
}  // namespace plumbline
