// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/scene_alignment.h"

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "engine/geometry/surface_sampling.h"
#include "tests/engine/evaluation/test_scene.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

Eigen::Vector3d RandomVector(Random& random) {
  return {random.Gaussian(), random.Gaussian(), random.Gaussian()};
}

TEST(FitYawAndTranslation, RecoversATurnAboutAnyDirectionOfGravity) {
  Random random({.seed = 5});
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::Vector3d up = RandomVector(random).normalized();
    Eigen::Isometry3d expected = Eigen::Isometry3d::Identity();
    expected.linear() = Eigen::AngleAxisd(random.Uniform(-3, 3), up).toRotationMatrix();
    expected.translation() = RandomVector(random);
    std::vector<Eigen::Vector3d> from, to;
    for (int i = 0; i < 2 + trial % 4; ++i) {
      from.push_back(RandomVector(random));
      to.push_back(expected * from.back());
    }
    EXPECT_THAT(FitYawAndTranslation(from, to, up), IsometryNear(expected, 1e-9, 1e-9));
  }
}

TEST(FitYawAndTranslation, KeepsGravityWhenThePairsDoNot) {
  Random random({.seed = 6});
  std::vector<Eigen::Vector3d> from, to;
  for (int i = 0; i < 5; ++i) {
    from.push_back(RandomVector(random));
    to.push_back(RandomVector(random));
  }
  const Eigen::Vector3d up = RandomVector(random).normalized();
  EXPECT_LT((FitYawAndTranslation(from, to, up).linear() * up - up).norm(), 1e-12);
}

TEST(FitYawAndTranslation, DoesNotTurnWhereNothingShowsATurn) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  EXPECT_TRUE(FitYawAndTranslation({}, {}, up).isApprox(Eigen::Isometry3d::Identity()));
  Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
  moved.translation() = Eigen::Vector3d(1, 0, 0);
  EXPECT_THAT(FitYawAndTranslation({{0, 0, 0}}, {{1, 0, 0}}, up), IsometryNear(moved, 1e-9, 1e-12));
  EXPECT_THAT(FitYawAndTranslation({{0, 0, 0}, {0, 0, 1}}, {{1, 0, 0}, {1, 1e-9, 1}}, up),
              IsometryNear(moved, 1e-9, 1e-8));
}

struct Aligned {
  Eigen::Isometry3d result, expected;
};

Aligned AlignMovedScene(const Eigen::Isometry3d& moved, const std::optional<Eigen::Vector3d>& up) {
  TriangleMesh scene = BoxMesh(1.6, 0.8, 0.75, 8);
  const std::shared_ptr<const ModelDatabase> database = TestDatabase();
  Append(Transformed(database->models()[0].mesh, UprightPose(1.2, 0.3, 0, 40)), scene);
  Append(Transformed(database->models()[0].mesh, UprightPose(-0.5, 1.1, 0, -70)), scene);
  const auto surface = ClosestTriangleSearch::Build(scene).value();
  std::vector<Eigen::Vector3d> points = SampleSurface(scene, 5000, 1).value().points;
  for (Eigen::Vector3d& point : points) point = moved * point;
  return {AlignToSurface(points, *surface, up), moved.inverse()};
}

TEST(AlignToSurface, FindsARigidMotion) {
  Eigen::Isometry3d moved = Eigen::Isometry3d::Identity();
  moved.linear() =
      Eigen::AngleAxisd(0.05, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  moved.translation() = Eigen::Vector3d(0.06, -0.04, 0.05);
  const Aligned aligned = AlignMovedScene(moved, std::nullopt);
  EXPECT_THAT(aligned.result, IsometryNear(aligned.expected, 1e-4, 1e-6));
}

TEST(AlignToSurface, KeepsGravityWhenTold) {
  Random random({.seed = 7});
  const Eigen::Isometry3d moved = UprightPose(0.06, -0.04, 0.05, 4);
  const Aligned aligned = AlignMovedScene(moved, Eigen::Vector3d::UnitZ());
  EXPECT_THAT(aligned.result, IsometryNear(aligned.expected, 1e-4, 1e-6));
  Eigen::Isometry3d tilted = moved;
  tilted.linear() =
      Eigen::AngleAxisd(0.03, Eigen::Vector3d::UnitX()).toRotationMatrix() * moved.linear();
  const Eigen::Isometry3d kept = AlignMovedScene(tilted, Eigen::Vector3d::UnitZ()).result;
  EXPECT_LT((kept.linear() * Eigen::Vector3d::UnitZ() - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(AlignToSurface, StaysWhereTheSurfaceShowsNothing) {
  const auto plane = ClosestTriangleSearch::Build(BoxMesh(10, 10, 0.01, 1)).value();
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(0.1 * (i % 10), 0.1 * (i / 10), 0.05);
  const Eigen::Isometry3d result = AlignToSurface(points, *plane, std::nullopt);
  EXPECT_NEAR(result.translation().z(), -0.04, 1e-6);
  EXPECT_LT(result.translation().head<2>().norm(), 1e-6);
}

}  // namespace
}  // namespace plumbline
