// SPDX-License-Identifier: Apache-2.0
#include "tests/support/furniture_models.h"

#include <numbers>

#include "tests/support/meshes.h"

namespace plumbline {
namespace {

/// Box by centre of its bottom and size.
void AddBlock(const Eigen::Vector3f& foot, const Eigen::Vector3f& size, TriangleMesh& mesh) {
  const Eigen::Vector3f half(size.x() / 2, size.y() / 2, 0);
  Append(MakeBox(foot - half, foot + half + Eigen::Vector3f(0, 0, size.z())), mesh);
}

CadModel Model(const char* name, const char* category, TriangleMesh mesh) {
  CadModel model;
  model.name = name;
  model.category = category;
  model.support = Support::kFloor;
  model.mesh = std::move(mesh);
  return model;
}

}  // namespace

TriangleMesh MakeCylinder(float radius, float height, int sides) {
  TriangleMesh mesh;
  mesh.vertices = {{0, 0, 0}, {0, 0, height}};
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / sides;
    const auto x = static_cast<float>(radius * std::cos(angle));
    const auto y = static_cast<float>(radius * std::sin(angle));
    mesh.vertices.emplace_back(x, y, 0.0f);
    mesh.vertices.emplace_back(x, y, height);
  }
  for (int i = 0; i < sides; ++i) {
    const int a = 2 + 2 * i, b = 2 + 2 * ((i + 1) % sides);
    mesh.triangles.emplace_back(a, b, a + 1);
    mesh.triangles.emplace_back(b, b + 1, a + 1);
    mesh.triangles.emplace_back(0, b, a);
    mesh.triangles.emplace_back(1, a + 1, b + 1);
  }
  return mesh;
}

TriangleMesh MakeChair(bool arm_rests) {
  TriangleMesh mesh;
  AddBlock({0, 0, 0.43f}, {0.45f, 0.45f, 0.03f}, mesh);
  for (const float x : {-0.20f, 0.20f}) {
    for (const float y : {-0.20f, 0.20f}) AddBlock({x, y, 0}, {0.04f, 0.04f, 0.43f}, mesh);
  }
  for (const float y : {-0.20f, 0.20f}) AddBlock({-0.20f, y, 0.46f}, {0.03f, 0.04f, 0.44f}, mesh);
  for (const float z : {0.58f, 0.70f, 0.82f}) AddBlock({-0.20f, 0, z}, {0.02f, 0.36f, 0.06f}, mesh);
  if (arm_rests) {
    for (const float y : {-0.22f, 0.22f}) {
      AddBlock({0, y, 0.66f}, {0.42f, 0.05f, 0.03f}, mesh);
      AddBlock({0.18f, y, 0.46f}, {0.04f, 0.04f, 0.20f}, mesh);
    }
  }
  return mesh;
}

TriangleMesh MakeTable() {
  TriangleMesh mesh;
  AddBlock({0, 0, 0.71f}, {1.3f, 0.7f, 0.03f}, mesh);
  for (const float x : {-0.59f, 0.59f}) {
    for (const float y : {-0.29f, 0.29f}) AddBlock({x, y, 0}, {0.06f, 0.06f, 0.71f}, mesh);
  }
  return mesh;
}

std::shared_ptr<const ModelDatabase> MakeFurnitureDatabase() {
  std::vector<CadModel> models;
  models.push_back(Model("chair", "chair", MakeChair(false)));
  models.push_back(Model("armchair", "chair", MakeChair(true)));
  models.push_back(Model("table", "dining table", MakeTable()));
  models.back().symmetry.order = 2;
  models.push_back(Model("crate", "suitcase", MakeBox({-0.2f, -0.12f, 0}, {0.2f, 0.12f, 0.3f})));
  models.back().support = Support::kAny;
  models.push_back(Model("vase", "vase", MakeCylinder(0.12f, 0.4f, 48)));
  models.back().symmetry.order = 0;
  return ModelDatabase::FromModels(std::move(models));
}

}  // namespace plumbline
