// SPDX-License-Identifier: Apache-2.0
// What the colours of a scan mean.

#include "ui/scene/scan_actor.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

using Eigen::Vector3d;

double Light(const std::array<std::uint8_t, 3>& rgb) {
  return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/// A column of points from the floor to 2 m, and a stray one far above.
TriangleMesh Column() {
  TriangleMesh cloud;
  for (int i = 0; i <= 400; ++i) cloud.vertices.emplace_back(0.0f, 0.0f, 0.005f * i);
  cloud.vertices.emplace_back(0.0f, 0.0f, 90.0f);
  return cloud;
}

/// A floor of one triangle and a wall of one.
TriangleMesh Corner() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 0, 0}, {3, 1, 0}, {3, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  return mesh;
}

TEST(ScanColors, ByHeightGrowBrighterUpwardsWhateverStrayPointsThereAre) {
  const auto colors = ScanColors(Column(), Vector3d::UnitZ(), ScanColoring::kHeight);
  ASSERT_EQ(colors.size(), 402u);
  EXPECT_GT(Light(colors[300]), Light(colors[200]) + 10);
  EXPECT_GT(Light(colors[200]), Light(colors[100]) + 10);
  const auto upside_down = ScanColors(Column(), -Vector3d::UnitZ(), ScanColoring::kHeight);
  EXPECT_LT(Light(upside_down[300]), Light(upside_down[100]));
}

TEST(ScanColors, ByNormalTellFloorsFromWalls) {
  const auto colors = ScanColors(Corner(), Vector3d::UnitZ(), ScanColoring::kNormal);
  EXPECT_GT(colors[0][2], colors[0][0] + 80) << "the floor is blue";
  EXPECT_LT(colors[3][2], std::max(colors[3][0], colors[3][1]) - 80);
  EXPECT_TRUE(HasNormals(Corner()));
  EXPECT_FALSE(HasNormals(Column()));
  EXPECT_EQ(ScanColors(Column(), Vector3d::UnitZ(), ScanColoring::kNormal),
            ScanColors(Column(), Vector3d::UnitZ(), ScanColoring::kHeight))
      << "a cloud without normals";
}

TEST(ScanColors, AreItsOwnWhereItHasAny) {
  TriangleMesh scan = Corner();
  scan.colors.assign(scan.vertices.size(), {200, 10, 10});
  EXPECT_TRUE(HasColors(scan));
  const auto own = ScanColors(scan, Vector3d::UnitZ(), ScanColoring::kOwn);
  EXPECT_GT(own[0][0], 100);
  EXPECT_LT(own[0][1], 20);
  EXPECT_EQ(ScanColors(scan, Vector3d::UnitZ(), std::nullopt), own);
  scan.colors.clear();
  EXPECT_NE(ScanColors(scan, Vector3d::UnitZ(), ScanColoring::kOwn), own);
}

}  // namespace
}  // namespace plumbline
