// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "engine/synthetic/furniture.h"
#include "engine/synthetic/furniture_parts.h"

namespace plumbline {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector2f;
using Eigen::Vector3f;

Matrix3f LeanBack(float angle_rad) {
  return Eigen::AngleAxisf(-angle_rad, Vector3f::UnitY()).toRotationMatrix();
}

}  // namespace

FurnitureModel RectangularTable(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "table_rectangular";
  model.category = "dining table";
  model.symmetry_order = 2;
  model.note = "dining table for four to six, long side along y";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.wood);
  AddBox(mesh, wood,
         {.center = {0, 0, 0.726f},
          .size = {0.86f, 1.48f, 0.03f},
          .radius = 0.009f,
          .arc = 2,
          .divisions = {4, 7, 1}});
  for (const float x : {-1.0f, 1.0f}) {
    for (const float y : {-1.0f, 1.0f}) {
      AddBar(mesh, wood,
             {.from = {x * 0.375f, y * 0.68f, 0.712f},
              .to = {x * 0.39f, y * 0.70f, 0},
              .start = {0.07f, 0.07f},
              .end = {0.038f, 0.038f},
              .radius = 0.012f});
    }
    AddBox(mesh, wood,
           {.center = {x * 0.365f, 0, 0.668f},
            .size = {0.022f, 1.30f, 0.085f},
            .radius = 0.004f,
            .arc = 2,
            .divisions = {1, 6, 2}});
  }
  for (const float y : {-1.0f, 1.0f}) {
    AddBox(mesh, wood,
           {.center = {0, y * 0.665f, 0.668f},
            .size = {0.70f, 0.022f, 0.085f},
            .radius = 0.004f,
            .arc = 2,
            .divisions = {4, 1, 2}});
  }
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel RoundTable(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "table_round";
  model.category = "dining table";
  model.symmetry_order = 0;
  model.note = "round table on one foot";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.wood);
  const int foot = model.body.Paint(palette.lacquer);
  AddLathe(mesh, wood, {0, 0, 0},
           {{0, 0.712f},
            {0.30f, 0.712f},
            {0.515f, 0.714f},
            {0.527f, 0.72f},
            {0.53f, 0.729f},
            {0.526f, 0.737f},
            {0.515f, 0.741f},
            {0.3f, 0.742f},
            {0, 0.742f}},
           72);
  AddLathe(mesh, foot, {0, 0, 0},
           {{0, 0},
            {0.285f, 0},
            {0.29f, 0.008f},
            {0.285f, 0.016f},
            {0.2f, 0.026f},
            {0.11f, 0.05f},
            {0.062f, 0.10f},
            {0.044f, 0.18f},
            {0.04f, 0.34f},
            {0.045f, 0.52f},
            {0.065f, 0.62f},
            {0.11f, 0.68f},
            {0.19f, 0.708f},
            {0.24f, 0.712f},
            {0, 0.712f}},
           48);
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel CoffeeTable(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "table_coffee";
  model.category = "dining table";
  model.symmetry_order = 2;
  model.note = "low table with a shelf, long side along y";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.dark_wood);
  const int metal = model.body.Paint(palette.metal);
  AddBox(mesh, wood,
         {.center = {0, 0, 0.405f},
          .size = {0.55f, 1.0f, 0.03f},
          .radius = 0.01f,
          .arc = 2,
          .divisions = {4, 6, 1}});
  AddBox(mesh, wood,
         {.center = {0, 0, 0.16f},
          .size = {0.46f, 0.88f, 0.018f},
          .radius = 0.006f,
          .arc = 2,
          .divisions = {3, 5, 1}});
  for (const float x : {-1.0f, 1.0f}) {
    for (const float y : {-1.0f, 1.0f}) {
      AddTube(mesh, metal,
              {{x * 0.235f, y * 0.44f, 0},
               {x * 0.225f, y * 0.43f, 0.2f},
               {x * 0.215f, y * 0.42f, 0.392f}},
              {0.01f, 0.013f, 0.014f}, 16);
    }
    AddTube(mesh, metal, {{x * 0.217f, -0.42f, 0.38f}, {x * 0.217f, 0.42f, 0.38f}}, {0.009f}, 12);
  }
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel WideSofa(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "sofa_wide";
  model.category = "couch";
  model.note = "three seats";
  PaintedMesh& mesh = model.body.mesh;
  const int cloth = model.body.Paint(palette.fabric);
  const int wood = model.body.Paint(palette.dark_wood);
  AddBox(mesh, cloth, {.center = {0, 0, 0.235f}, .size = {0.84f, 1.90f, 0.19f}, .radius = 0.03f});
  AddBox(mesh, cloth,
         {.center = {-0.355f, 0, 0.50f},
          .size = {0.15f, 1.90f, 0.52f},
          .radius = 0.05f,
          .arc = 2,
          .divisions = {1, 2, 1},
          .rotation = LeanBack(0.06f)});
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, cloth,
           {.center = {0, side * 0.95f, 0.38f},
            .size = {0.88f, 0.17f, 0.46f},
            .radius = 0.055f,
            .arc = 2,
            .divisions = {2, 1, 1}});
    for (const float x : {-0.35f, 0.35f}) {
      AddTube(mesh, wood, {{x, side * 0.93f, 0}, {x, side * 0.93f, 0.16f}}, {0.016f, 0.026f}, 8);
    }
  }
  for (int i = -1; i <= 1; ++i) {
    const float y = 0.578f * static_cast<float>(i);
    AddCushion(mesh, cloth, {0.085f, y, 0.395f}, {0.70f, 0.57f, 0.15f}, 0.30f,
               Matrix3f::Identity());
    AddCushion(mesh, cloth, {-0.215f, y, 0.625f}, {0.17f, 0.565f, 0.40f}, 0.30f, LeanBack(0.22f));
  }
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel SmallSofa(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "sofa_small";
  model.category = "couch";
  model.note = "two seats, high legs";
  PaintedMesh& mesh = model.body.mesh;
  const int cloth = model.body.Paint(palette.second_fabric);
  const int wood = model.body.Paint(palette.wood);
  AddBox(mesh, cloth,
         {.center = {0.02f, 0, 0.275f}, .size = {0.74f, 1.44f, 0.13f}, .radius = 0.03f, .arc = 2});
  AddCushion(mesh, cloth, {0.07f, 0, 0.395f}, {0.64f, 1.26f, 0.13f}, 0.25f, Matrix3f::Identity());
  const std::size_t first = mesh.vertices.size();
  AddBox(mesh, cloth,
         {.center = {0, 0, 0.56f},
          .size = {0.13f, 1.46f, 0.48f},
          .radius = 0.06f,
          .arc = 3,
          .divisions = {1, 12, 4}});
  Deform(mesh, first, [](const Vector3f& p) {
    const float wing = std::max(0.0f, std::abs(p.y()) - 0.45f);
    return Vector3f(p.x() - 0.30f - 0.22f * (p.z() - 0.4f) + 1.1f * wing * wing, p.y(), p.z());
  });
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, cloth,
           {.center = {0.01f, side * 0.69f, 0.43f},
            .size = {0.70f, 0.10f, 0.32f},
            .radius = 0.045f,
            .arc = 3,
            .divisions = {3, 1, 1}});
    for (const float x : {-0.28f, 0.33f}) {
      AddTube(mesh, wood, {{x * 1.08f, side * 0.64f, 0}, {x, side * 0.60f, 0.22f}},
              {0.013f, 0.024f}, 12);
    }
  }
  StandOnOrigin(model.body.mesh);
  return model;
}

}  // namespace plumbline
