// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/mesh.h"

#include <cmath>

#include <gtest/gtest.h>

namespace plumbline {
namespace {

/// A unit square in the plane z = 0 that faces +z.
TriangleMesh Square() {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(BoundingBox, HoldsAllVerticesAndIsEmptyWithoutAny) {
  EXPECT_TRUE(BoundingBox(TriangleMesh()).isEmpty());
  const Eigen::AlignedBox3f box = BoundingBox(Square());
  EXPECT_EQ(box.min(), Eigen::Vector3f(0, 0, 0));
  EXPECT_EQ(box.max(), Eigen::Vector3f(1, 1, 0));
}

TEST(Transformed, MovesVerticesAndOnlyTurnsNormals) {
  TriangleMesh mesh = Square();
  ComputeNormals(mesh);
  Eigen::Isometry3d target_from_mesh(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  target_from_mesh.translation() = Eigen::Vector3d(10, 20, 30);
  const TriangleMesh moved = Transformed(mesh, target_from_mesh);
  EXPECT_LT((moved.vertices[2] - Eigen::Vector3f(11, 20, 31)).norm(), 1e-5f);
  EXPECT_LT((moved.normals[2] - Eigen::Vector3f(0, -1, 0)).norm(), 1e-6f);
  EXPECT_EQ(moved.triangles, mesh.triangles);
}

TEST(Append, ShiftsTheIndicesOfWhatIsAdded) {
  TriangleMesh mesh = Square();
  Append(Square(), mesh);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  ASSERT_EQ(mesh.triangles.size(), 4u);
  EXPECT_EQ(mesh.triangles[3], Eigen::Vector3i(4, 6, 7));
}

TEST(Append, KeepsAttributesThatBothHaveAndDropsTheOthers) {
  TriangleMesh first = Square(), second = Square();
  first.colors.assign(4, {1, 2, 3});
  second.colors.assign(4, {4, 5, 6});
  ComputeNormals(first);
  Append(second, first);
  EXPECT_EQ(first.colors.size(), 8u);
  EXPECT_EQ(first.colors[7][2], 6);
  EXPECT_TRUE(first.normals.empty());
}

TEST(Append, ToAnEmptyMeshIsACopy) {
  TriangleMesh square = Square(), empty;
  square.colors.assign(4, {1, 2, 3});
  square.texture_coordinates.assign(4, {0, 0});
  square.texture_file = "wood.png";
  ComputeNormals(square);
  Append(square, empty);
  EXPECT_EQ(empty.colors, square.colors);
  EXPECT_EQ(empty.normals, square.normals);
  EXPECT_EQ(empty.texture_file, "wood.png");
}

TEST(ComputeNormals, WeighsFacesByTheirArea) {
  // A large face in z = 0 and one of a tenth of its area in x = 0 share the edge from 0 to 1.
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, 0, 0.1f}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}};
  ComputeNormals(mesh);
  EXPECT_LT((mesh.normals[0] - Eigen::Vector3f(0.1f, 0, 1).normalized()).norm(), 1e-6f);
  EXPECT_LT((mesh.normals[2] - Eigen::Vector3f(0, 0, 1)).norm(), 1e-6f);
  EXPECT_LT((mesh.normals[3] - Eigen::Vector3f(1, 0, 0)).norm(), 1e-6f);
}

TEST(ComputeNormals, IsFiniteWithoutAFaceOfPositiveArea) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {5, 5, 5}};
  mesh.triangles = {{0, 1, 2}};
  ComputeNormals(mesh);
  for (const Eigen::Vector3f& normal : mesh.normals) EXPECT_EQ(normal, Eigen::Vector3f(0, 0, 1));
}

}  // namespace
}  // namespace plumbline
