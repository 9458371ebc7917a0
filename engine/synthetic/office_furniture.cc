// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "engine/synthetic/furniture.h"
#include "engine/synthetic/furniture_parts.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

Material SteelWhite() {
  return {.color = ColorFromHex(0xd9dcda), .gloss = 0.05f, .roughness = 0.2f};
}

Material DarkPlastic() {
  return {.color = ColorFromHex(0x2e3033), .gloss = 0.03f, .roughness = 0.3f};
}

float Within(Random& random, float low, float high) {
  return static_cast<float>(random.Uniform(low, high));
}

/// Pot, earth and leaf of a plant; returns the paint of the leaf.
int AddPot(PaintedBody& body, float radius, float height, std::uint32_t glaze,
           std::uint32_t green) {
  const int pot = body.Paint({.color = ColorFromHex(glaze), .gloss = 0.04f, .roughness = 0.15f});
  const int earth = body.Paint({.pattern = Pattern::kPlaster, .color = ColorFromHex(0x3d2d22)});
  AddLathe(body.mesh, pot, {0, 0, 0},
           {{0, 0},
            {0.74f * radius, 0},
            {0.80f * radius, 0.02f * height},
            {radius, height},
            {0.92f * radius, height},
            {0.90f * radius, 0.92f * height},
            {0, 0.92f * height}},
           32);
  AddLathe(body.mesh, earth, {0, 0, 0.92f * height}, {{0.9f * radius, 0}, {0, 0.01f * height}}, 16);
  const Vector3f tone = ColorFromHex(green);
  return body.Paint({.pattern = Pattern::kLeaf,
                     .color = tone,
                     .accent = tone * 1.7f,
                     .gloss = 0.03f,
                     .roughness = 0.4f,
                     .seed = 8});
}

}  // namespace

FurnitureModel StraightDesk(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "desk_straight";
  model.category = "desk";
  model.note = "desk on a steel frame, long side along y; the sitter is at +x";
  PaintedMesh& mesh = model.body.mesh;
  const int top = model.body.Paint(palette.lacquer);
  const int steel = model.body.Paint(palette.metal);
  AddBox(mesh, top,
         {.center = {0, 0, 0.727f},
          .size = {0.80f, 1.60f, 0.026f},
          .radius = 0.004f,
          .arc = 2,
          .divisions = {4, 8, 1}});
  for (const float side : {-1.0f, 1.0f}) {
    // A C-shaped frame: foot, column towards the back, arm under the top.
    AddBox(mesh, steel,
           {.center = {0, side * 0.70f, 0.018f},
            .size = {0.72f, 0.06f, 0.034f},
            .radius = 0.008f,
            .arc = 2,
            .divisions = {4, 1, 1}});
    AddBox(mesh, steel,
           {.center = {-0.12f, side * 0.70f, 0.36f},
            .size = {0.09f, 0.055f, 0.66f},
            .radius = 0.008f,
            .arc = 2,
            .divisions = {1, 1, 4}});
    AddBox(mesh, steel,
           {.center = {-0.02f, side * 0.70f, 0.694f},
            .size = {0.64f, 0.05f, 0.036f},
            .radius = 0.006f,
            .arc = 1,
            .divisions = {4, 1, 1}});
    for (const float x : {-0.33f, 0.33f})
      AddLathe(mesh, steel, {x, side * 0.70f, 0},
               {{0, 0}, {0.02f, 0}, {0.02f, 0.004f}, {0, 0.004f}}, 12);
  }
  AddBox(mesh, steel,
         {.center = {-0.12f, 0, 0.62f},
          .size = {0.04f, 1.36f, 0.06f},
          .radius = 0.004f,
          .divisions = {1, 6, 1}});
  // Modesty panel at the back.
  AddBox(mesh, top,
         {.center = {-0.35f, 0, 0.53f},
          .size = {0.018f, 1.36f, 0.34f},
          .radius = 0.003f,
          .divisions = {1, 6, 2}});
  StandOnOrigin(mesh);
  return model;
}

FurnitureModel SideDesk(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "desk_drawers";
  model.category = "desk";
  model.note = "small wooden desk with two drawers under the top; the sitter is at +x";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.wood);
  const int front = model.body.Paint(palette.lacquer);
  const int metal = model.body.Paint(palette.metal);
  AddBox(mesh, wood,
         {.center = {0, 0, 0.738f},
          .size = {0.60f, 1.20f, 0.024f},
          .radius = 0.008f,
          .arc = 2,
          .divisions = {4, 8, 1}});
  AddBox(mesh, wood,
         {.center = {-0.02f, 0, 0.665f},
          .size = {0.50f, 1.06f, 0.12f},
          .radius = 0.004f,
          .divisions = {3, 6, 2}});
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, front,
           {.center = {0.235f, side * 0.265f, 0.665f},
            .size = {0.018f, 0.50f, 0.10f},
            .radius = 0.003f,
            .divisions = {1, 4, 1}});
    AddLathe(mesh, metal, {0.26f, side * 0.265f, 0.655f},
             {{0, 0}, {0.012f, 0.002f}, {0.014f, 0.01f}, {0.012f, 0.018f}, {0, 0.02f}}, 16);
    for (const float x : {-1.0f, 1.0f}) {
      AddBar(mesh, wood,
             {.from = {x * 0.225f, side * 0.50f, 0.61f},
              .to = {x * 0.26f, side * 0.55f, 0},
              .start = {0.05f, 0.05f},
              .end = {0.026f, 0.026f},
              .radius = 0.009f});
    }
  }
  // A raised back keeps things from falling down.
  AddBox(mesh, wood,
         {.center = {-0.285f, 0, 0.80f},
          .size = {0.018f, 1.16f, 0.10f},
          .radius = 0.006f,
          .arc = 2,
          .divisions = {1, 6, 1}});
  StandOnOrigin(mesh);
  return model;
}

FurnitureModel VisitorChair(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "chair_visitor";
  model.category = "chair";
  model.note = "cantilever chair: seat and back on one bent steel tube";
  PaintedMesh& mesh = model.body.mesh;
  const int tube =
      model.body.Paint({.color = ColorFromHex(0xa4a8aa), .gloss = 0.2f, .roughness = 0.06f});
  const int cloth = model.body.Paint(palette.fabric);
  const int plastic = model.body.Paint(DarkPlastic());
  const auto at = [](float side, float x, float z) { return Vector3f(x, side * 0.235f, z); };
  for (const float side : {-1.0f, 1.0f}) {
    // Runner on the floor, front leg, arm under the seat, upright of the back.
    AddTube(
        mesh, tube,
        SmoothPath({at(side, -0.25f, 0.0125f), at(side, 0.0f, 0.0125f), at(side, 0.20f, 0.0125f),
                    at(side, 0.245f, 0.035f), at(side, 0.245f, 0.20f), at(side, 0.235f, 0.40f),
                    at(side, 0.19f, 0.435f), at(side, 0.0f, 0.43f), at(side, -0.17f, 0.425f),
                    at(side, -0.215f, 0.46f), at(side, -0.25f, 0.62f), at(side, -0.31f, 0.87f)},
                   2),
        {0.0125f}, 12);
    AddBlock(mesh, plastic, at(side, 0.10f, 0.003f), {0.05f, 0.03f, 0.006f}, 0.002f);
    // Short arm rest on a stub of the upright.
    AddBox(mesh, plastic,
           {.center = at(side * 1.06f, -0.12f, 0.66f),
            .size = {0.28f, 0.045f, 0.026f},
            .radius = 0.01f,
            .arc = 2,
            .divisions = {3, 1, 1}});
  }
  AddTube(mesh, tube, {at(-1, -0.25f, 0.0125f), at(1, -0.25f, 0.0125f)}, {0.0125f}, 12);
  std::size_t first = mesh.vertices.size();
  AddBox(mesh, cloth,
         {.center = {0, 0, 0.46f},
          .size = {0.45f, 0.445f, 0.05f},
          .radius = 0.022f,
          .arc = 2,
          .divisions = {5, 5, 1}});
  Deform(mesh, first, [](const Vector3f& p) {
    const float front = std::max(0.0f, p.x() - 0.1f);
    return Vector3f(p.x(), p.y(), p.z() - 1.2f * front * front);
  });
  first = mesh.vertices.size();
  AddBox(mesh, cloth,
         {.center = {0, 0, 0.70f},
          .size = {0.035f, 0.445f, 0.36f},
          .radius = 0.016f,
          .arc = 2,
          .divisions = {1, 6, 4}});
  Deform(mesh, first, [](const Vector3f& p) {
    const float lean = -0.24f - 0.24f * (p.z() - 0.60f);
    return Vector3f(lean + p.x() + 0.5f * p.y() * p.y(), p.y(), p.z());
  });
  StandOnOrigin(mesh);
  return model;
}

FurnitureModel BinderShelf(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "shelf_tall";
  model.category = "shelf";
  model.note = "2 m high: three open compartments over two doors";
  model.back = true;  // Wherever it is placed, it stands at a wall.
  PaintedMesh& mesh = model.body.mesh;
  const int body = model.body.Paint(palette.lacquer);
  const int wood = model.body.Paint(palette.wood);
  const int metal = model.body.Paint(palette.metal);
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, body,
           {.center = {0, side * 0.389f, 1.0f},
            .size = {0.40f, 0.022f, 2.0f},
            .radius = 0.003f,
            .arc = 2,
            .divisions = {2, 1, 8}});
  }
  for (const float z : {0.06f, 0.80f, 1.18f, 1.56f, 1.98f}) {
    AddBox(mesh, body,
           {.center = {-0.005f, 0, z},
            .size = {0.385f, 0.756f, 0.022f},
            .radius = 0.003f,
            .arc = 1,
            .divisions = {2, 4, 1}});
  }
  AddBox(mesh, body,
         {.center = {-0.194f, 0, 1.02f},
          .size = {0.008f, 0.756f, 1.94f},
          .radius = 0.002f,
          .divisions = {1, 4, 8}});
  AddBlock(mesh, body, {0.16f, 0, 0.026f}, {0.02f, 0.756f, 0.05f});
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, wood,
           {.center = {0.192f, side * 0.189f, 0.43f},
            .size = {0.018f, 0.372f, 0.71f},
            .radius = 0.003f,
            .divisions = {1, 3, 5}});
    AddTube(mesh, metal, {{0.222f, side * 0.035f, 0.52f}, {0.222f, side * 0.035f, 0.68f}}, {0.006f},
            10);
    for (const float z : {0.53f, 0.67f})
      AddTube(mesh, metal, {{0.198f, side * 0.035f, z}, {0.222f, side * 0.035f, z}}, {0.005f}, 8);
  }
  StandOnOrigin(mesh);
  return model;
}

FurnitureModel CubeShelf(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "shelf_cubes";
  model.category = "shelf";
  model.symmetry_order = 2;
  model.note = "2 x 3 open cubes without a back, 1.14 m high";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.wood);
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, wood,
           {.center = {0, side * 0.371f, 0.57f},
            .size = {0.39f, 0.038f, 1.14f},
            .radius = 0.004f,
            .arc = 2,
            .divisions = {3, 1, 6}});
  }
  for (const float z : {0.019f, 1.121f}) {
    AddBox(mesh, wood,
           {.center = {0, 0, z},
            .size = {0.39f, 0.704f, 0.038f},
            .radius = 0.004f,
            .arc = 2,
            .divisions = {3, 4, 1}});
  }
  for (const float z : {0.387f, 0.755f}) {
    AddBox(mesh, wood,
           {.center = {0, 0, z},
            .size = {0.38f, 0.704f, 0.016f},
            .radius = 0.003f,
            .divisions = {3, 6, 1}});
  }
  for (int i = 0; i < 3; ++i) {
    AddBox(mesh, wood,
           {.center = {0, 0, 0.2065f + 0.3635f * static_cast<float>(i)},
            .size = {0.38f, 0.016f, 0.336f},
            .radius = 0.003f,
            .divisions = {3, 1, 3}});
  }
  StandOnOrigin(mesh);
  return model;
}

FurnitureModel DrawerPedestal(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "pedestal_drawers";
  model.category = "cabinet";
  model.note = "rolling pedestal with three drawers, 0.57 m high";
  PaintedMesh& mesh = model.body.mesh;
  const int body = model.body.Paint(SteelWhite());
  const int front = model.body.Paint(palette.lacquer);
  const int plastic = model.body.Paint(DarkPlastic());
  AddBox(mesh, body,
         {.center = {-0.01f, 0, 0.31f},
          .size = {0.56f, 0.42f, 0.50f},
          .radius = 0.008f,
          .arc = 2,
          .divisions = {4, 3, 4}});
  const float bottoms[] = {0.075f, 0.315f, 0.44f}, heights[] = {0.23f, 0.115f, 0.115f};
  for (int i = 0; i < 3; ++i) {
    AddBox(mesh, front,
           {.center = {0.277f, 0, bottoms[i] + heights[i] / 2},
            .size = {0.018f, 0.408f, heights[i]},
            .radius = 0.004f,
            .arc = 2,
            .divisions = {1, 4, 2}});
    AddBox(mesh, plastic,
           {.center = {0.288f, 0, bottoms[i] + heights[i] - 0.03f},
            .size = {0.014f, 0.14f, 0.018f},
            .radius = 0.006f,
            .arc = 2,
            .divisions = {1, 3, 1}});
  }
  for (const float x : {-0.22f, 0.20f}) {
    for (const float y : {-0.16f, 0.16f}) {
      AddTube(mesh, plastic, {{x, y, 0.035f}, {x, y, 0.065f}}, {0.012f}, 10);
      AddTube(mesh, plastic, {{x, y - 0.02f, 0.024f}, {x, y, 0.024f}, {x, y + 0.02f, 0.024f}},
              {0.022f, 0.024f, 0.022f}, 14);
    }
  }
  StandOnOrigin(mesh);
  return model;
}

FurnitureModel TallPlant() {
  FurnitureModel model;
  model.name = "plant_tall";
  model.category = "potted plant";
  model.note = "rubber tree of 1.5 m in a pot";
  PaintedBody& body = model.body;
  const int leaf = AddPot(body, 0.17f, 0.32f, 0x6f7a7c, 0x3a6642);
  const int bark = body.Paint({.color = ColorFromHex(0x6b5a40)});
  Random random({.seed = 5, .object = 0x504c54});
  for (int stem = 0; stem < 3; ++stem) {
    const float azimuth = 2 * kPiF * static_cast<float>(stem) / 3 + 0.4f;
    const float height = 1.38f - 0.24f * static_cast<float>(stem);
    const Vector3f out(std::cos(azimuth), std::sin(azimuth), 0);
    const auto path = SmoothPath(
        {out * 0.03f + Vector3f(0, 0, 0.28f), out * 0.06f + Vector3f(0, 0, 0.5f * height),
         out * 0.13f + Vector3f(0, 0, height)},
        6);
    AddTube(body.mesh, bark, path, {0.009f}, 8);
    constexpr int kLeaves = 6;
    for (int i = 0; i < kLeaves; ++i) {
      const auto at =
          static_cast<std::size_t>(3 + i * static_cast<int>(path.size() - 4) / (kLeaves - 1));
      const float turn = azimuth + 2.4f * static_cast<float>(i) + Within(random, -0.3f, 0.3f);
      const float width = Within(random, 0.10f, 0.13f), length = Within(random, 0.22f, 0.30f),
                  rise = Within(random, 0.5f, 0.95f);
      AddLeaf(body.mesh, leaf, path[at], turn, rise, length, width, {4, 2});
    }
  }
  StandOnOrigin(body.mesh);
  return model;
}

FurnitureModel SmallPlant() {
  FurnitureModel model;
  model.name = "plant_small";
  model.category = "potted plant";
  model.support = Support::kAny;
  model.note = "pot plant of 0.35 m; stands on a desk";
  PaintedBody& body = model.body;
  const int leaf = AddPot(body, 0.07f, 0.13f, 0xd8d2c6, 0x4f8046);
  Random random({.seed = 6, .object = 0x504c54});
  constexpr int kLeaves = 20;
  for (int i = 0; i < kLeaves; ++i) {
    const float inner = static_cast<float>(i) / kLeaves;  // the last stand upright in the middle
    const float turn = 2.4f * static_cast<float>(i) + Within(random, -0.2f, 0.2f);
    const Vector3f root =
        0.03f * (1 - inner) * Vector3f(std::cos(turn), std::sin(turn), 0) + Vector3f(0, 0, 0.12f);
    const float width = Within(random, 0.035f, 0.05f), length = Within(random, 0.19f, 0.25f);
    AddLeaf(body.mesh, leaf, root, turn, 0.55f + 0.85f * inner, length, width, {4, 2});
  }
  StandOnOrigin(body.mesh);
  return model;
}

std::vector<FurnitureModel> OfficeCatalogue(const FurniturePalette& palette) {
  return {
      StraightDesk(palette), SideDesk(palette),  OfficeChair(palette, true), VisitorChair(palette),
      BinderShelf(palette),  CubeShelf(palette), DrawerPedestal(palette),    DeskMonitor(palette),
      TallPlant(),           SmallPlant()};
}

std::vector<FurnitureModel> TwinCatalogue(const FurniturePalette& palette) {
  std::vector<FurnitureModel> models = FurnitureCatalogue(palette);
  FurnitureModel plain = OfficeChair(palette, false);
  plain.name = "chair_office_plain";
  plain.note = "chair_office without arm rests";
  models.push_back(std::move(plain));
  return models;
}

}  // namespace plumbline
