// SPDX-License-Identifier: Apache-2.0
#include "engine/models/mesh_cleanup.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "engine/models/mesh_decimation.h"
#include "tests/support/meshes.h"

namespace plumbline {
namespace {

TEST(MeshCleanup, MergesAndDropsAndCounts) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {9, 9, 9}};
  mesh.triangles = {{0, 1, 2}, {3, 5, 4}, {2, 0, 1}, {2, 3, 0}, {1, 3, 5}, {0, 0, 1}};
  CleanupReport report;
  const TriangleMesh clean = CleanMesh(mesh, report);
  EXPECT_EQ(report.merged_vertices, 2);
  EXPECT_EQ(report.duplicate_faces, 2) << "also in another order";
  EXPECT_EQ(report.degenerate_faces, 2);
  EXPECT_EQ(report.unreferenced_vertices, 1);
  EXPECT_EQ(clean.vertices.size(), 4u);
  EXPECT_EQ(clean.triangles.size(), 2u);
}

TEST(MeshCleanup, KeepsSeamsOfColourAndTexture) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 5, 4}};
  mesh.texture_coordinates = {{0, 0}, {1, 0}, {0, 1}, {0.5f, 0}, {0, 1}, {1, 1}};
  CleanupReport report;
  EXPECT_EQ(CleanMesh(mesh, report).vertices.size(), 5u) << "only the pair that agrees is merged";
  EXPECT_EQ(CountEdges(mesh).open, 4) << "a texture seam is no open edge";
}

TEST(MeshCleanup, CountsOpenAndNonManifoldEdges) {
  const TriangleMesh box = MakeBox({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(CountEdges(box).open, 0);
  TriangleMesh finned = box;
  Append(MakeParallelogram({0, 0, 0}, {1, 0, 0}, {0, -1, 0}), finned);
  EXPECT_EQ(CountEdges(finned).open, 3);
  EXPECT_EQ(CountEdges(finned).non_manifold, 1);
}

TEST(MeshDecimation, MeetsTheBudgetAndStaysOnTheSphere) {
  const TriangleMesh sphere = MakeSphere(0.5f, 80);
  DecimationReport report;
  const Result<TriangleMesh> small = DecimateMesh(sphere, 1000, report);
  ASSERT_TRUE(small.ok()) << small.error().message;
  EXPECT_LE(small->triangles.size(), 1000u);
  EXPECT_GT(small->triangles.size(), 900u);
  // The sagitta of 1000 equal triangles on this sphere is about 1.5 mm.
  EXPECT_LT(report.mean_error_m, 0.002);
  EXPECT_LT(report.max_error_m, 0.01);
  EXPECT_EQ(CountEdges(*small).open, 0);
}

TEST(MeshDecimation, TakesColoursFromTheNearestPointOfTheSource) {
  TriangleMesh sphere = MakeSphere(0.5f, 80);
  for (const Eigen::Vector3f& v : sphere.vertices) {
    sphere.colors.push_back({static_cast<std::uint8_t>(127 + 250 * v.x()),
                             static_cast<std::uint8_t>(127 + 250 * v.z()), 40});
  }
  DecimationReport report;
  const Result<TriangleMesh> small = DecimateMesh(sphere, 1000, report);
  ASSERT_TRUE(small.ok());
  ASSERT_EQ(small->colors.size(), small->vertices.size());
  EXPECT_LT(report.mean_color_error, 2.0);
}

TEST(MeshDecimation, KeepsTextureCoordinatesAndTheirSeam) {
  // A fine sheet folded along a seam: u jumps from 0.4 to 0.6 there.
  TriangleMesh sheet;
  const int n = 40;
  for (int half = 0; half < 2; ++half) {
    TriangleMesh part;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        const float a = static_cast<float>(i) / n, b = static_cast<float>(j) / n;
        part.vertices.push_back(half == 0 ? Eigen::Vector3f(a - 1, b, 0.1f * b * b)
                                          : Eigen::Vector3f(a, b, 0.1f * b * b + 0.5f * a));
        part.texture_coordinates.emplace_back(half == 0 ? 0.4f * a : 0.6f + 0.4f * a, b);
        if (i == n || j == n) continue;
        const int k = i * (n + 1) + j;
        part.triangles.emplace_back(k, k + n + 1, k + 1);
        part.triangles.emplace_back(k + 1, k + n + 1, k + n + 2);
      }
    }
    part.texture_file = "t.png";
    if (half == 0)
      sheet = part;
    else
      Append(part, sheet);
  }
  DecimationReport report;
  const Result<TriangleMesh> small = DecimateMesh(sheet, 300, report);
  ASSERT_TRUE(small.ok()) << small.error().message;
  ASSERT_EQ(small->texture_coordinates.size(), small->vertices.size());
  EXPECT_EQ(small->texture_file, "t.png");
  for (const Eigen::Vector3i& t : small->triangles) {
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector2f uv = small->texture_coordinates[static_cast<std::size_t>(t[c])];
      const Eigen::Vector3f& v = small->vertices[static_cast<std::size_t>(t[c])];
      const bool left = small->texture_coordinates[static_cast<std::size_t>(t[0])].x() < 0.5f;
      EXPECT_EQ(uv.x() < 0.5f, left) << "no face crosses the seam in the texture";
      EXPECT_NEAR(uv.x(), left ? 0.4f * (v.x() + 1) : 0.6f + 0.4f * v.x(), 0.03);
      EXPECT_NEAR(uv.y(), v.y(), 0.03);
    }
  }
  const TriangleMesh welded = WeldedGeometry(*small);
  std::map<std::pair<int, int>, int> seam;
  for (const Eigen::Vector3i& t : welded.triangles) {
    for (int c = 0; c < 3; ++c) {
      const std::pair<int, int> edge = std::minmax({t[c], t[(c + 1) % 3]});
      const float a = welded.vertices[static_cast<std::size_t>(edge.first)].x();
      const float b = welded.vertices[static_cast<std::size_t>(edge.second)].x();
      if (std::abs(a) < 1e-4f && std::abs(b) < 1e-4f) ++seam[edge];
    }
  }
  for (const auto& [edge, faces] : seam) EXPECT_EQ(faces, 2) << "the seam is not torn open";
}

TEST(MeshDecimation, LeavesSmallMeshesAlone) {
  DecimationReport report;
  const TriangleMesh box = MakeBox({0, 0, 0}, {1, 1, 1});
  EXPECT_EQ(DecimateMesh(box, 12, report)->triangles, box.triangles);
}

}  // namespace
}  // namespace plumbline
