// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/surface_error.h"

#include <gtest/gtest.h>

#include "engine/base/random.h"
#include "tests/engine/evaluation/test_scene.h"

namespace plumbline {
namespace {

TEST(Statistics, MatchesHandComputedNumbers) {
  const ErrorStatistics odd = Statistics({3, 1, 2, 10, 4});
  EXPECT_DOUBLE_EQ(odd.mean_m, 4);
  EXPECT_DOUBLE_EQ(odd.median_m, 3);
  EXPECT_DOUBLE_EQ(odd.std_m, std::sqrt(10.0));
  EXPECT_DOUBLE_EQ(odd.max_m, 10);
  EXPECT_EQ(odd.samples, 5);
  EXPECT_DOUBLE_EQ(Statistics({4, 1, 3, 2}).median_m, 2.5);
  EXPECT_EQ(Statistics({}).samples, 0);
}

TEST(MeasureDistances, TellsTheTriangleFromItsPlane) {
  TriangleMesh floor;
  floor.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  floor.triangles = {{0, 1, 2}};
  const auto search = ClosestTriangleSearch::Build(floor).value();
  // Above the triangle, and beside it: 0.3 above its plane, 0.4 away from its edge.
  const SurfaceDistances distances = MeasureDistances({{0.2, 0.2, 0.3}, {0.5, -0.4, 0.3}}, *search);
  EXPECT_NEAR(distances.to_triangle_m[0], 0.3, 1e-9);
  EXPECT_NEAR(distances.to_plane_m[0], 0.3, 1e-9);
  EXPECT_NEAR(distances.to_triangle_m[1], 0.5, 1e-9);
  EXPECT_NEAR(distances.to_plane_m[1], 0.3, 1e-9);
}

TEST(MeasureDistances, AgreesWithBruteForceOverAllTriangles) {
  const TriangleMesh box = BoxMesh(1, 0.7, 0.4, 3);
  const auto search = ClosestTriangleSearch::Build(box).value();
  Random random({.seed = 4});
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i)
    points.emplace_back(random.Gaussian(), random.Gaussian(), random.Gaussian());
  const SurfaceDistances distances = MeasureDistances(points, *search);
  for (std::size_t i = 0; i < points.size(); ++i) {
    // Outside a box the distance has a closed form; inside it is to the nearest side.
    const Eigen::Vector3d q =
        (points[i] - Eigen::Vector3d(0, 0, 0.2)).cwiseAbs() - Eigen::Vector3d(0.5, 0.35, 0.2);
    const double expected = (q.array() <= 0).all() ? -q.maxCoeff() : q.cwiseMax(0).norm();
    EXPECT_NEAR(distances.to_triangle_m[i], expected, 1e-7);
    EXPECT_LE(distances.to_plane_m[i], distances.to_triangle_m[i]);
  }
}

}  // namespace
}  // namespace plumbline
