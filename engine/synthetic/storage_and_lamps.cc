// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "engine/synthetic/furniture.h"
#include "engine/synthetic/furniture_parts.h"

namespace plumbline {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

/// A flat panel whose front (+x) shows a picture of size (y, z).
void AddScreen(PaintedBody& body, const Vector3f& center, float width, float height) {
  Material screen{.pattern = Pattern::kScreen,
                  .color = {0.3f, 0.35f, 0.4f},
                  .accent = {0.75f, 0.8f, 0.8f},
                  .gloss = 0.04f,
                  .roughness = 0.03f,
                  .emission = 0.8f,
                  .extent = {width, height},
                  .seed = 5};
  AddBox(body.mesh, body.Paint(screen),
         {.center = center,
          .size = {0.004f, width, height},
          .radius = 0.001f,
          .divisions = {1, 8, 5},
          .grain = 1});
}

void AddHandle(PaintedMesh& mesh, int paint, const Vector3f& center, const Vector3f& along) {
  const Vector3f out(0.026f, 0, 0), half = along / 2;
  AddTube(mesh, paint, {center - half + out, center + half + out}, {0.006f}, 8);
  for (const float end : {-0.8f, 0.8f}) {
    AddTube(mesh, paint, {center + end * half, center + end * half + out}, {0.005f}, 6);
  }
}

/// Legs of a piece of furniture, splayed outwards, under the corners (x, y).
void AddSplayedLegs(PaintedMesh& mesh, int paint, float x, float y, float height) {
  for (const float sx : {-1.0f, 1.0f}) {
    for (const float sy : {-1.0f, 1.0f}) {
      AddTube(mesh, paint, {{sx * x * 1.06f, sy * y * 1.04f, 0}, {sx * x, sy * y, height}},
              {0.012f, 0.021f}, 12);
    }
  }
}

}  // namespace

FurnitureModel DeskMonitor(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "monitor_desk";
  model.category = "tv";
  model.support = Support::kAny;
  model.note = "24-inch computer screen; stands on a table";
  PaintedBody& body = model.body;
  const int plastic =
      body.Paint({.color = ColorFromHex(0x2b2d30), .gloss = 0.03f, .roughness = 0.25f});
  const int metal = body.Paint(palette.metal);
  AddBox(body.mesh, plastic,
         {.center = {0.01f, 0, 0.325f},
          .size = {0.026f, 0.56f, 0.335f},
          .radius = 0.005f,
          .arc = 2,
          .divisions = {1, 6, 4}});
  AddBox(body.mesh, plastic,
         {.center = {-0.015f, 0, 0.31f},
          .size = {0.04f, 0.34f, 0.20f},
          .radius = 0.015f,
          .arc = 2,
          .divisions = {1, 4, 3}});
  AddScreen(body, {0.0225f, 0, 0.329f}, 0.535f, 0.302f);
  AddBar(body.mesh, metal,
         {.from = {-0.045f, 0, 0.008f},
          .to = {-0.04f, 0, 0.33f},
          .start = {0.02f, 0.06f},
          .end = {0.02f, 0.05f}});
  AddBox(body.mesh, metal,
         {.center = {0, 0, 0.007f},
          .size = {0.20f, 0.25f, 0.012f},
          .radius = 0.005f,
          .arc = 2,
          .divisions = {4, 4, 1}});
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel WideTv(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "tv_wide";
  model.category = "tv";
  model.support = Support::kAny;
  model.note = "45-inch television on two feet";
  PaintedBody& body = model.body;
  const int plastic =
      body.Paint({.color = ColorFromHex(0x202225), .gloss = 0.04f, .roughness = 0.2f});
  const int metal = body.Paint(palette.metal);
  AddBox(body.mesh, plastic,
         {.center = {0, 0, 0.37f},
          .size = {0.03f, 1.02f, 0.595f},
          .radius = 0.005f,
          .arc = 2,
          .divisions = {1, 10, 6}});
  AddBox(body.mesh, plastic,
         {.center = {-0.025f, 0, 0.27f},
          .size = {0.05f, 0.8f, 0.3f},
          .radius = 0.02f,
          .arc = 2,
          .divisions = {1, 5, 3}});
  AddScreen(body, {0.0145f, 0, 0.373f}, 0.995f, 0.565f);
  for (const float side : {-1.0f, 1.0f}) {
    AddBar(body.mesh, metal,
           {.from = {0, side * 0.36f, 0.085f},
            .to = {0.11f, side * 0.38f, 0.008f},
            .start = {0.015f, 0.03f},
            .end = {0.015f, 0.03f}});
    AddBar(body.mesh, metal,
           {.from = {0, side * 0.36f, 0.085f},
            .to = {-0.11f, side * 0.38f, 0.008f},
            .start = {0.015f, 0.03f},
            .end = {0.015f, 0.03f}});
  }
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel DoorCabinet(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "cabinet_doors";
  model.category = "cabinet";
  model.back = true;
  model.note = "two doors, 1.2 m high";
  PaintedMesh& mesh = model.body.mesh;
  const int body = model.body.Paint(palette.lacquer);
  const int wood = model.body.Paint(palette.wood);
  const int metal = model.body.Paint(palette.metal);
  AddBox(mesh, body,
         {.center = {-0.01f, 0, 0.655f},
          .size = {0.40f, 0.95f, 1.07f},
          .radius = 0.004f,
          .divisions = {2, 4, 5}});
  AddBox(mesh, wood,
         {.center = {0, 0, 1.202f},
          .size = {0.44f, 1.0f, 0.025f},
          .radius = 0.006f,
          .arc = 2,
          .divisions = {3, 6, 1}});
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, body,
           {.center = {0.197f, side * 0.237f, 0.655f},
            .size = {0.018f, 0.466f, 1.05f},
            .radius = 0.004f,
            .divisions = {1, 4, 5}});
    AddBox(mesh, body,
           {.center = {0.207f, side * 0.237f, 0.655f},
            .size = {0.012f, 0.34f, 0.92f},
            .radius = 0.005f,
            .divisions = {1, 3, 5},
            .grain = 2});
    AddHandle(mesh, metal, {0.206f, side * 0.035f, 0.70f}, {0, 0, 0.16f});
  }
  AddSplayedLegs(mesh, wood, 0.15f, 0.41f, 0.13f);
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel Sideboard(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "sideboard";
  model.category = "cabinet";
  model.back = true;
  model.note = "low: drawers between two doors";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.dark_wood);
  const int front = model.body.Paint(palette.lacquer);
  const int metal = model.body.Paint(palette.metal);
  AddBox(mesh, wood,
         {.center = {0, 0, 0.425f},
          .size = {0.42f, 1.50f, 0.53f},
          .radius = 0.006f,
          .arc = 2,
          .divisions = {2, 6, 3}});
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, front,
           {.center = {0.208f, side * 0.50f, 0.425f},
            .size = {0.02f, 0.46f, 0.48f},
            .radius = 0.004f,
            .divisions = {1, 4, 4}});
    AddHandle(mesh, metal, {0.217f, side * 0.31f, 0.47f}, {0, 0, 0.12f});
  }
  for (int i = 0; i < 3; ++i) {
    const float z = 0.265f + 0.16f * static_cast<float>(i);
    AddBox(mesh, front,
           {.center = {0.208f, 0, z},
            .size = {0.02f, 0.50f, 0.15f},
            .radius = 0.004f,
            .divisions = {1, 4, 2}});
    AddHandle(mesh, metal, {0.217f, 0, z}, {0, 0.14f, 0});
  }
  AddSplayedLegs(mesh, wood, 0.15f, 0.64f, 0.17f);
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel Bookshelf(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "bookshelf";
  model.category = "cabinet";
  model.back = true;
  model.note = "open shelf, 1.75 m high";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.wood);
  const int back = model.body.Paint(palette.lacquer);
  for (const float side : {-1.0f, 1.0f}) {
    AddBox(mesh, wood,
           {.center = {0, side * 0.41f, 0.875f},
            .size = {0.29f, 0.022f, 1.75f},
            .radius = 0.004f,
            .arc = 2,
            .divisions = {2, 1, 8}});
  }
  for (int i = 0; i < 6; ++i) {
    const float z = 0.07f + 0.333f * static_cast<float>(i);
    AddBox(mesh, wood,
           {.center = {0, 0, z},
            .size = {0.28f, 0.80f, 0.02f},
            .radius = 0.003f,
            .arc = 1,
            .divisions = {2, 4, 1}});
  }
  AddBox(mesh, back,
         {.center = {-0.138f, 0, 0.90f},
          .size = {0.01f, 0.80f, 1.66f},
          .radius = 0.002f,
          .divisions = {1, 4, 8}});
  AddBlock(mesh, wood, {0.1f, 0, 0.03f}, {0.02f, 0.80f, 0.06f});
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel FloorLamp(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "lamp_floor";
  model.category = "lamp";
  model.symmetry_order = 0;
  model.note = "floor lamp with a drum shade";
  PaintedMesh& mesh = model.body.mesh;
  const int metal = model.body.Paint(palette.metal);
  const int shade = model.body.Paint(palette.lampshade);
  AddLathe(mesh, metal, {0, 0, 0},
           {{0, 0},
            {0.15f, 0},
            {0.155f, 0.006f},
            {0.15f, 0.014f},
            {0.06f, 0.024f},
            {0.02f, 0.034f},
            {0.012f, 0.06f},
            {0.012f, 1.50f},
            {0, 1.50f}},
           40);
  AddLathe(mesh, shade, {0, 0, 0},
           {{0.215f, 1.30f},
            {0.205f, 1.40f},
            {0.185f, 1.58f},
            {0.182f, 1.58f},
            {0.202f, 1.40f},
            {0.212f, 1.30f},
            {0.215f, 1.30f}},
           48);
  AddLathe(mesh, shade, {0, 0, 0},
           {{0, 1.415f}, {0.03f, 1.43f}, {0.04f, 1.46f}, {0.03f, 1.49f}, {0, 1.505f}}, 16);
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel TableLamp(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "lamp_table";
  model.category = "lamp";
  model.symmetry_order = 0;
  model.support = Support::kAny;
  model.note = "table lamp with a ceramic foot";
  PaintedMesh& mesh = model.body.mesh;
  const int ceramic = model.body.Paint(palette.plastic);
  const int shade = model.body.Paint(palette.lampshade);
  AddLathe(mesh, ceramic, {0, 0, 0},
           {{0, 0},
            {0.07f, 0},
            {0.075f, 0.008f},
            {0.095f, 0.06f},
            {0.10f, 0.10f},
            {0.085f, 0.15f},
            {0.05f, 0.19f},
            {0.025f, 0.215f},
            {0.018f, 0.24f},
            {0.012f, 0.35f},
            {0, 0.35f}},
           40);
  AddLathe(mesh, shade, {0, 0, 0},
           {{0.15f, 0.25f},
            {0.14f, 0.32f},
            {0.11f, 0.44f},
            {0.107f, 0.44f},
            {0.137f, 0.32f},
            {0.147f, 0.25f},
            {0.15f, 0.25f}},
           48);
  StandOnOrigin(model.body.mesh);
  return model;
}

}  // namespace plumbline
