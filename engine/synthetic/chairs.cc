// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <numbers>

#include "engine/geometry/angles.h"
#include "engine/synthetic/furniture.h"
#include "engine/synthetic/furniture_parts.h"

namespace plumbline {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

/// x of the slat chair's back at a height: upright below the seat, leaning back above it.
float SlatBackX(float z) {
  return z < 0.45f ? -0.19f - 0.10f * (0.45f - z) : -0.19f - 0.24f * (z - 0.45f);
}

void AddSlatBack(PaintedMesh& mesh, int wood) {
  for (const float side : {-1.0f, 1.0f}) {
    const std::size_t first = mesh.vertices.size();
    AddBox(mesh, wood,
           {.center = {0, side * 0.195f, 0.44f},
            .size = {0.034f, 0.03f, 0.88f},
            .radius = 0.009f,
            .arc = 1,
            .divisions = {1, 1, 12}});
    Deform(mesh, first, [&](const Vector3f& p) {
      const float taper = 1 - 0.35f * std::abs(p.z() - 0.45f) / 0.45f;
      return Vector3f(SlatBackX(p.z()) + p.x() * taper,
                      p.y() - side * 0.02f * std::max(0.0f, p.z() - 0.45f), p.z());
    });
  }
  const auto rail = [&](float z, float height) {
    const std::size_t first = mesh.vertices.size();
    AddBox(mesh, wood,
           {.center = {0, 0, z},
            .size = {0.02f, 0.37f, height},
            .radius = 0.008f,
            .arc = 1,
            .divisions = {1, 10, 2}});
    Deform(mesh, first, [&](const Vector3f& p) {
      const float bow = 1 - p.y() * p.y() / (0.19f * 0.19f);
      return Vector3f(SlatBackX(p.z()) + p.x() - 0.028f * bow, p.y(), p.z());
    });
  };
  rail(0.825f, 0.085f);
  rail(0.55f, 0.04f);
  for (int i = -2; i <= 2; ++i) {
    const float y = 0.064f * static_cast<float>(i);
    const std::size_t first = mesh.vertices.size();
    AddBox(mesh, wood,
           {.center = {0, y, 0.68f},
            .size = {0.011f, 0.03f, 0.24f},
            .radius = 0.004f,
            .divisions = {1, 1, 3}});
    Deform(mesh, first, [&](const Vector3f& p) {
      const float bow = 1 - y * y / (0.19f * 0.19f);
      return Vector3f(SlatBackX(p.z()) + p.x() - 0.028f * bow, p.y(), p.z());
    });
  }
}

void AddOfficeBase(PaintedMesh& mesh, int metal, int plastic) {
  for (int i = 0; i < 5; ++i) {
    const float angle = 2 * kPiF * (static_cast<float>(i) + 0.5f) / 5;
    const Vector3f out(std::cos(angle), std::sin(angle), 0);
    const std::size_t first = mesh.vertices.size();
    AddBox(mesh, metal,
           {.center = {0.165f, 0, 0},
            .size = {0.29f, 0.055f, 0.035f},
            .radius = 0.012f,
            .divisions = {4, 1, 1}});
    const Eigen::AngleAxisf turn(angle, Vector3f::UnitZ());
    Deform(mesh, first, [&](const Vector3f& p) {
      const float narrow = 1 - 1.4f * (p.x() - 0.02f);
      return Vector3f(turn *
                      Vector3f(p.x(), p.y() * narrow, 0.108f - 0.09f * p.x() + p.z() * narrow));
    });
    AddTube(mesh, plastic,
            {out * 0.29f + Vector3f(0, 0, 0.045f), out * 0.29f + Vector3f(0, 0, 0.085f)}, {0.011f},
            8);
    const Vector3f axle(-out.y(), out.x(), 0);
    for (const float side : {-1.0f, 1.0f}) {
      const Vector3f hub = out * 0.30f + Vector3f(0, 0, 0.028f);
      AddTube(mesh, plastic,
              {hub + side * axle * 0.008f, hub + side * axle * 0.013f, hub + side * axle * 0.028f},
              {0.023f, 0.028f, 0.025f}, 10);
    }
  }
  AddLathe(mesh, plastic, {0, 0, 0},
           {{0, 0.07f},
            {0.04f, 0.07f},
            {0.042f, 0.13f},
            {0.03f, 0.14f},
            {0.028f, 0.29f},
            {0.018f, 0.29f},
            {0.018f, 0.40f},
            {0, 0.40f}},
           16);
}

void AddOfficeArm(PaintedMesh& mesh, int plastic, float side) {
  const auto at = [&](float x, float y, float z) { return Vector3f(x, side * y, z); };
  AddTube(mesh, plastic,
          SmoothPath({at(-0.06f, 0.14f, 0.405f), at(-0.05f, 0.25f, 0.41f),
                      at(-0.05f, 0.285f, 0.46f), at(-0.05f, 0.285f, 0.63f)},
                     3),
          {0.017f}, 10);
  const std::size_t first = mesh.vertices.size();
  AddBox(mesh, plastic,
         {.center = {0, 0, 0},
          .size = {0.26f, 0.085f, 0.032f},
          .radius = 0.014f,
          .divisions = {5, 1, 1}});
  Deform(mesh, first, [&](const Vector3f& p) {
    return Vector3f(p.x() - 0.02f, side * 0.285f + p.y() + side * 0.25f * p.x() * p.x(),
                    0.64f + p.z() - 0.6f * p.x() * p.x());
  });
}

}  // namespace

FurnitureModel SlatChair(const FurniturePalette& palette, bool arm_rests) {
  FurnitureModel model;
  model.name = arm_rests ? "chair_slat_arms" : "chair_slat";
  model.category = "chair";
  model.note =
      arm_rests ? "wooden chair with slatted back and arm rests" : "wooden chair with slatted back";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.wood);
  const std::size_t first = mesh.vertices.size();
  AddBox(mesh, wood,
         {.center = {0.005f, 0, 0.452f},
          .size = {0.43f, 0.45f, 0.03f},
          .radius = 0.012f,
          .arc = 2,
          .divisions = {6, 6, 1},
          .grain = 0});
  Deform(mesh, first, [](const Vector3f& p) {
    const float u = (p.x() + 0.02f) / 0.21f, v = p.y() / 0.22f;
    const float dip = std::max(0.0f, 1 - u * u) * std::max(0.0f, 1 - v * v);
    return Vector3f(p.x(), p.y() * (1 + 0.10f * p.x()), p.z() - 0.014f * dip);
  });
  for (const float side : {-1.0f, 1.0f}) {
    AddBar(mesh, wood,
           {.from = {0.175f, side * 0.195f, 0.445f},
            .to = {0.195f, side * 0.205f, 0},
            .start = {0.036f, 0.036f},
            .end = {0.024f, 0.024f},
            .radius = 0.008f});
    AddBlock(mesh, wood, {-0.01f, side * 0.198f, 0.41f}, {0.35f, 0.018f, 0.05f});
    AddBar(mesh, wood,
           {.from = {-0.205f, side * 0.196f, 0.2f},
            .to = {0.183f, side * 0.2f, 0.2f},
            .start = {0.022f, 0.014f},
            .end = {0.022f, 0.014f}});
  }
  AddBlock(mesh, wood, {0.178f, 0, 0.41f}, {0.018f, 0.36f, 0.05f});
  AddBlock(mesh, wood, {-0.19f, 0, 0.41f}, {0.018f, 0.36f, 0.05f});
  AddSlatBack(mesh, wood);
  if (arm_rests) {
    for (const float side : {-1.0f, 1.0f}) {
      const std::size_t arm = mesh.vertices.size();
      AddBox(mesh, wood,
             {.center = {-0.02f, side * 0.225f, 0},
              .size = {0.44f, 0.055f, 0.024f},
              .radius = 0.01f,
              .arc = 1,
              .divisions = {7, 1, 1}});
      Deform(mesh, arm, [&](const Vector3f& p) {
        const float swing = (p.x() - 0.08f) * (p.x() - 0.08f);
        return Vector3f(p.x(), p.y() - side * 0.25f * swing,
                        0.665f + p.z() - 0.12f * p.x() + 0.2f * swing);
      });
      AddBar(mesh, wood,
             {.from = {0.14f, side * 0.222f, 0.43f},
              .to = {0.15f, side * 0.224f, 0.645f},
              .start = {0.034f, 0.026f},
              .end = {0.026f, 0.024f},
              .radius = 0.007f});
    }
  }
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel ShellChair(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "chair_shell";
  model.category = "chair";
  model.note = "moulded shell on four splayed legs";
  PaintedMesh& mesh = model.body.mesh;
  const int shell = model.body.Paint(palette.plastic);
  const int wood = model.body.Paint(palette.wood);
  const int metal = model.body.Paint(palette.metal);
  // The shell is a thin plate bent along this profile (front edge of the seat to the top of the
  // back).
  const std::vector<Vector3f> profile = SmoothPath({{0.235f, 0, 0.425f},
                                                    {0.19f, 0, 0.452f},
                                                    {0.05f, 0, 0.44f},
                                                    {-0.10f, 0, 0.435f},
                                                    {-0.18f, 0, 0.475f},
                                                    {-0.215f, 0, 0.58f},
                                                    {-0.245f, 0, 0.72f},
                                                    {-0.285f, 0, 0.83f}},
                                                   8);
  const auto along = [&](float s) {
    const float position = std::clamp(s, 0.0f, 1.0f) * static_cast<float>(profile.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(position), profile.size() - 2);
    return Vector3f(profile[i] +
                    (profile[i + 1] - profile[i]) * (position - static_cast<float>(i)));
  };
  const std::size_t first = mesh.vertices.size();
  AddBox(mesh, shell,
         {.center = {0.5f, 0, 0},
          .size = {1, 0.47f, 0.011f},
          .radius = 0.005f,
          .divisions = {26, 16, 1}});
  Deform(mesh, first, [&](const Vector3f& p) {
    const float s = p.x();
    const Vector3f tangent = (along(s + 0.05f) - along(s - 0.05f)).normalized();
    const Vector3f normal = Vector3f::UnitY().cross(tangent);  // towards the sitter
    const float round = std::min(1.0f, std::min(s, 1 - s) / 0.16f);
    const float width =
        (1 - 0.12f * s) * std::sqrt(std::max(0.02f, 1 - 0.42f * (1 - round) * (1 - round)));
    const float t = p.y() / 0.235f;
    const float curl = 0.075f * std::sin(kPiF * std::clamp(0.15f + 0.8f * s, 0.0f, 1.0f)) * t * t;
    return Vector3f(along(s) - Vector3f(0, p.y() * width, 0) + normal * (p.z() + curl));
  });
  const auto foot = [](float x, float y) { return Vector3f(x * 0.225f, y * 0.215f, 0); };
  const auto top = [](float x, float y) { return Vector3f(x * 0.115f - 0.01f, y * 0.12f, 0.432f); };
  for (const float x : {-1.0f, 1.0f}) {
    for (const float y : {-1.0f, 1.0f}) {
      AddTube(mesh, wood, {foot(x, y), 0.5f * (foot(x, y) + top(x, y)), top(x, y)},
              {0.011f, 0.017f, 0.019f}, 12);
      AddTube(mesh, metal,
              {0.72f * top(x, y) + 0.28f * foot(x, y), 0.5f * (top(-x, y) + foot(-x, y))}, {0.005f},
              8);
      AddTube(mesh, metal,
              {0.72f * top(x, y) + 0.28f * foot(x, y), 0.5f * (top(x, -y) + foot(x, -y))}, {0.005f},
              8);
    }
  }
  AddBlock(mesh, metal, {-0.01f, 0, 0.424f}, {0.25f, 0.26f, 0.012f});
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel OfficeChair(const FurniturePalette& palette, bool arm_rests) {
  FurnitureModel model;
  model.name = "chair_office";
  model.category = "chair";
  model.note = "swivel chair on a five-star base; base and seat as one rigid shape";
  PaintedMesh& mesh = model.body.mesh;
  const int fabric = model.body.Paint(palette.second_fabric);
  const int plastic =
      model.body.Paint({.color = ColorFromHex(0x33363a), .gloss = 0.03f, .roughness = 0.3f});
  const int metal = model.body.Paint(palette.metal);
  AddOfficeBase(mesh, metal, plastic);
  AddBlock(mesh, plastic, {-0.02f, 0, 0.405f}, {0.22f, 0.18f, 0.04f}, 0.012f);
  std::size_t first = mesh.vertices.size();
  AddBox(mesh, fabric,
         {.center = {0.01f, 0, 0.465f},
          .size = {0.49f, 0.50f, 0.085f},
          .radius = 0.035f,
          .arc = 2,
          .divisions = {5, 5, 1}});
  Deform(mesh, first, [](const Vector3f& p) {
    const float front = std::max(0.0f, p.x() - 0.12f);
    return Vector3f(p.x(), p.y() * (1 - 0.15f * std::abs(p.x() - 0.02f)),
                    p.z() - 1.6f * front * front);
  });
  const auto back_x = [](float z) {
    return -0.235f - 0.16f * (z - 0.55f) + 0.35f * (z - 0.72f) * (z - 0.72f);
  };
  first = mesh.vertices.size();
  AddBox(mesh, fabric,
         {.center = {0, 0, 0.80f},
          .size = {0.055f, 0.46f, 0.50f},
          .radius = 0.025f,
          .arc = 2,
          .divisions = {1, 6, 6}});
  Deform(mesh, first, [&](const Vector3f& p) {
    const float narrow =
        1 - 0.28f * std::max(0.0f, p.z() - 0.8f) - 0.2f * std::max(0.0f, 0.7f - p.z());
    return Vector3f(back_x(p.z()) + p.x() + 0.9f * p.y() * p.y(), p.y() * narrow, p.z());
  });
  first = mesh.vertices.size();
  AddBox(mesh, plastic,
         {.center = {0, 0, 0.56f},
          .size = {0.024f, 0.075f, 0.38f},
          .radius = 0.008f,
          .divisions = {1, 1, 9}});
  Deform(mesh, first, [&](const Vector3f& p) {
    const float bend = std::max(0.0f, 0.55f - p.z());
    return Vector3f(back_x(std::max(p.z(), 0.5f)) - 0.035f + 3.0f * bend * bend + p.x(), p.y(),
                    p.z() + 0.02f);
  });
  AddBlock(mesh, plastic, {-0.16f, 0, 0.405f}, {0.17f, 0.07f, 0.025f}, 0.008f);
  if (arm_rests) {
    for (const float side : {-1.0f, 1.0f}) AddOfficeArm(mesh, plastic, side);
  }
  StandOnOrigin(model.body.mesh);
  return model;
}

FurnitureModel RoundStool(const FurniturePalette& palette) {
  FurnitureModel model;
  model.name = "stool_round";
  model.category = "chair";
  model.symmetry_order = 4;
  model.note = "round seat on four legs";
  PaintedMesh& mesh = model.body.mesh;
  const int wood = model.body.Paint(palette.dark_wood);
  const int cushion = model.body.Paint(palette.second_fabric);
  AddLathe(mesh, wood, {0, 0, 0},
           {{0, 0.43f}, {0.155f, 0.43f}, {0.165f, 0.437f}, {0.165f, 0.45f}, {0, 0.45f}}, 32);
  AddLathe(mesh, cushion, {0, 0, 0},
           {{0, 0.45f},
            {0.15f, 0.45f},
            {0.163f, 0.458f},
            {0.167f, 0.472f},
            {0.16f, 0.486f},
            {0.13f, 0.495f},
            {0.06f, 0.499f},
            {0, 0.5f}},
           32);
  std::vector<Vector3f> ring;
  for (int i = 0; i <= 32; ++i) {
    const float angle = 2 * kPiF * static_cast<float>(i % 32) / 32;
    ring.emplace_back(0.152f * std::cos(angle), 0.152f * std::sin(angle), 0.19f);
  }
  AddTube(mesh, wood, ring, {0.008f}, 8);
  for (int i = 0; i < 4; ++i) {
    const Eigen::AngleAxisf turn(kPiF / 4 + kPiF / 2 * static_cast<float>(i), Vector3f::UnitZ());
    AddTube(mesh, wood,
            {turn * Vector3f(0.182f, 0, 0), turn * Vector3f(0.155f, 0, 0.19f),
             turn * Vector3f(0.12f, 0, 0.435f)},
            {0.011f, 0.015f, 0.018f}, 12);
  }
  StandOnOrigin(model.body.mesh);
  return model;
}

}  // namespace plumbline
