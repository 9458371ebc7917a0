// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/painted_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

using Eigen::Vector3f;

double SignedVolume(const PaintedMesh& mesh) {
  double volume = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    volume += mesh.vertices[t[0]].cast<double>().dot(
                  mesh.vertices[t[1]].cast<double>().cross(mesh.vertices[t[2]].cast<double>())) /
              6;
  }
  return volume;
}

double Area(const PaintedMesh& mesh) {
  double area = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    area += 0.5 * (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                      .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                      .norm();
  }
  return area;
}

/// Shading normals point to the same side as the faces.
void ExpectNormalsOutwards(const PaintedMesh& mesh) {
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Vector3f face = (mesh.vertices[t[1]] - mesh.vertices[t[0]])
                              .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(mesh.normals[t[k]].norm(), 1, 1e-4);
      EXPECT_GT(mesh.normals[t[k]].dot(face), 0);
    }
  }
}

TEST(PaintedMesh, BoxHasItsVolumeAndFacesOutwards) {
  PaintedMesh mesh;
  AddBox(mesh, 0, {.center = {1, 2, 3}, .size = {0.4f, 0.6f, 0.8f}, .radius = 0.001f});
  EXPECT_NEAR(SignedVolume(mesh), 0.4 * 0.6 * 0.8, 1e-4);
  ExpectNormalsOutwards(mesh);
}

TEST(PaintedMesh, LatheOfARectangleIsACylinder) {
  PaintedMesh mesh;
  AddLathe(mesh, 0, {0, 0, 0}, {{0, 0}, {0.5f, 0}, {0.5f, 1}, {0, 1}}, 128);
  EXPECT_NEAR(SignedVolume(mesh), std::numbers::pi * 0.25, 2e-3);
  ExpectNormalsOutwards(mesh);
}

TEST(PaintedMesh, TubeHasTheVolumeOfABar) {
  PaintedMesh mesh;
  AddTube(mesh, 0, {{0, 0, 0}, {0.3f, 0.1f, 0.9f}}, {0.05f}, 64);
  const double length = Vector3f(0.3f, 0.1f, 0.9f).norm();
  EXPECT_NEAR(SignedVolume(mesh), std::numbers::pi * 0.0025 * length, 3e-5);
  ExpectNormalsOutwards(mesh);
}

TEST(PaintedMesh, DeformingTurnsNormalsWithTheSurface) {
  PaintedMesh mesh;
  AddBox(
      mesh, 0,
      {.center = {0, 0, 0}, .size = {1, 1, 1}, .radius = 0.05f, .arc = 3, .divisions = {6, 6, 6}});
  Deform(mesh, 0, [](const Vector3f& p) {
    return Vector3f(p.x() + 0.3f * p.z() * p.z(), 2 * p.y(), p.z());
  });
  ExpectNormalsOutwards(mesh);
  EXPECT_NEAR(SignedVolume(mesh), 2, 0.03);
}

TEST(PaintedMesh, RefiningShortensEdgesAndKeepsTheSurface) {
  PaintedMesh mesh;
  AddBox(mesh, 0, {.center = {0, 0, 0}, .size = {2, 1, 0.1f}});
  const double area = Area(mesh), volume = SignedVolume(mesh);
  Refine(mesh, 0.2f);
  EXPECT_NEAR(Area(mesh), area, 1e-4);
  EXPECT_NEAR(SignedVolume(mesh), volume, 1e-5);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE((mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm(), 0.2f);
    }
  }
}

}  // namespace
}  // namespace plumbline
