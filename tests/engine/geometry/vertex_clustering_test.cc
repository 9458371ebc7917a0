// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/vertex_clustering.h"

#include <gtest/gtest.h>

namespace plumbline {
namespace {

/// A square of side 1 in z = 0 with n x n quads.
TriangleMesh Sheet(int n) {
  TriangleMesh mesh;
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) {
      mesh.vertices.emplace_back(static_cast<float>(x) / n, static_cast<float>(y) / n, 0);
      mesh.colors.push_back({static_cast<std::uint8_t>(200 * x / n), 10, 20});
    }
  }
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x;
      mesh.triangles.emplace_back(a, a + 1, a + n + 2);
      mesh.triangles.emplace_back(a, a + n + 2, a + n + 1);
    }
  }
  return mesh;
}

TEST(VertexClustering, KeepsShapeColourAndWindingOfASheet) {
  const TriangleMesh coarse = ClusterVertices(Sheet(100), 0.1001);
  EXPECT_EQ(coarse.vertices.size(), 100u);
  EXPECT_EQ(coarse.colors.size(), 100u);
  EXPECT_GT(coarse.triangles.size(), 150u);
  EXPECT_LT(coarse.triangles.size(), 400u);
  for (const Eigen::Vector3i& t : coarse.triangles) {
    const Eigen::Vector3f normal = (coarse.vertices[t[1]] - coarse.vertices[t[0]])
                                       .cross(coarse.vertices[t[2]] - coarse.vertices[t[0]]);
    EXPECT_GE(normal.z(), -1e-6f);
  }
  const Eigen::AlignedBox3f box = BoundingBox(coarse);
  EXPECT_NEAR(box.min().x(), 0.05, 0.01);
  EXPECT_NEAR(box.max().x(), 0.95, 0.06);
}

TEST(VertexClustering, ComesNearTheNumberAskedFor) {
  const TriangleMesh fine = Sheet(300);
  const TriangleMesh coarse = ClusterToAbout(fine, 2000);
  EXPECT_LT(coarse.vertices.size(), 2600u);
  EXPECT_GT(coarse.vertices.size(), 900u);
  EXPECT_EQ(ClusterToAbout(fine, 1'000'000).vertices.size(), fine.vertices.size());
}

TEST(VertexClustering, KeepsCloudsAsClouds) {
  TriangleMesh cloud = Sheet(50);
  cloud.triangles.clear();
  cloud.colors.clear();
  const TriangleMesh coarse = ClusterToAbout(cloud, 300);
  EXPECT_TRUE(coarse.triangles.empty());
  EXPECT_TRUE(coarse.colors.empty());
  EXPECT_GT(coarse.vertices.size(), 50u);
  EXPECT_LT(coarse.vertices.size(), 400u);
  EXPECT_TRUE(ClusterVertices({}, 1).empty());
}

}  // namespace
}  // namespace plumbline
