// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/decor.h"

#include <array>
#include <cmath>
#include <numbers>

#include "engine/geometry/angles.h"
#include "engine/synthetic/furniture_parts.h"

namespace plumbline {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector2f;
using Eigen::Vector3f;

float Between(Random& random, float low, float high) {
  return static_cast<float>(random.Uniform(low, high));
}

Material BookCover(Random& random) {
  constexpr std::array<std::uint32_t, 10> kCovers = {0x7c3b34, 0x2f4a5c, 0xd8cfbb, 0x3f5a4a,
                                                     0xb58a3a, 0x4a4552, 0xa5583b, 0x8fa3a5,
                                                     0x2c2f33, 0xc9b79a};
  return {.pattern = Pattern::kBook,
          .color = ColorFromHex(kCovers[random.Index(kCovers.size())]),
          .accent = ColorFromHex(random.Uniform() < 0.5 ? 0xe8dcc0 : 0x3a342c),
          .seed = random.Bits() % 1000};
}

Vector3f CeramicColor(Random& random) {
  constexpr std::array<std::uint32_t, 6> kGlazes = {0xe6e0d4, 0x4e7a85, 0xb9653f,
                                                    0x8c9a78, 0x39444c, 0xd6b35c};
  return ColorFromHex(kGlazes[random.Index(kGlazes.size())]);
}

Matrix3f TurnZ(float angle) {
  return Eigen::AngleAxisf(angle, Vector3f::UnitZ()).toRotationMatrix();
}

}  // namespace

PaintedBody BookRow(float length_m, Random& random) {
  PaintedBody body;
  float y = -length_m / 2;
  while (true) {
    const float thick = Between(random, 0.018f, 0.045f), high = Between(random, 0.17f, 0.25f);
    const float deep = Between(random, 0.12f, 0.17f);
    if (y + thick > length_m / 2) break;
    const bool leaning = random.Uniform() < 0.12 && y + thick + 0.06f < length_m / 2;
    const float lean = leaning ? 0.22f : 0.0f;
    const Matrix3f tilt = Eigen::AngleAxisf(lean, Vector3f::UnitX()).toRotationMatrix();
    const float rise = 0.5f * (high * std::cos(lean) + thick * std::sin(lean));
    const float shift = 0.5f * (thick * std::cos(lean) + high * std::sin(lean));
    const float x = Between(random, -0.01f, 0.01f);
    AddBox(body.mesh, body.Paint(BookCover(random)),
           {.center = {x, y + shift, rise},
            .size = {deep, thick, high},
            .radius = 0.003f,
            .rotation = tilt,
            .grain = 2});
    y += 2 * shift + 0.001f;
    if (random.Uniform() < 0.07) y += 0.05f;
  }
  return body;
}

PaintedBody BookStack(int books, Random& random) {
  PaintedBody body;
  float z = 0;
  for (int i = 0; i < books; ++i) {
    const float thick = Between(random, 0.015f, 0.04f);
    const float deep = Between(random, 0.14f, 0.19f), high = Between(random, 0.20f, 0.26f);
    const Matrix3f turn = TurnZ(Between(random, -0.3f, 0.3f));
    AddBox(body.mesh, body.Paint(BookCover(random)),
           {.center = {0, 0, z + thick / 2},
            .size = {deep, high, thick},
            .radius = 0.003f,
            .rotation = turn,
            .grain = 1});
    z += thick;
  }
  return body;
}

PaintedBody PottedPlant(float height_m, Random& random) {
  PaintedBody body;
  const float pot = std::min(0.30f, 0.32f * height_m), radius = 0.5f * pot;
  const int clay =
      body.Paint({.pattern = Pattern::kPlaster, .color = CeramicColor(random), .gloss = 0.03f});
  const int earth = body.Paint({.pattern = Pattern::kPlaster, .color = ColorFromHex(0x3d2d22)});
  const Vector3f green = ColorFromHex(random.Uniform() < 0.5 ? 0x4d7a3a : 0x3d6b4a);
  const int leaf = body.Paint({.pattern = Pattern::kLeaf,
                               .color = green,
                               .accent = green * 1.8f,
                               .gloss = 0.03f,
                               .roughness = 0.4f,
                               .seed = random.Bits() % 1000});
  const int stalk = body.Paint({.color = ColorFromHex(0x5e6b3a)});
  AddLathe(body.mesh, clay, {0, 0, 0},
           {{0, 0},
            {0.72f * radius, 0},
            {0.78f * radius, 0.01f},
            {radius, pot},
            {0.9f * radius, pot},
            {0.88f * radius, 0.9f * pot},
            {0, 0.9f * pot}},
           28);
  AddLathe(body.mesh, earth, {0, 0, 0.9f * pot}, {{0.88f * radius, 0}, {0, 0.01f}}, 20);
  const int stems = 7 + static_cast<int>(random.Index(4));
  for (int i = 0; i < stems; ++i) {
    const float azimuth =
        2 * kPiF * (static_cast<float>(i) + Between(random, 0, 0.7f)) / static_cast<float>(stems);
    const float reach = height_m * Between(random, 0.10f, 0.28f);
    const float top = pot + (height_m - pot) * Between(random, 0.35f, 1.0f);
    const Vector3f out(std::cos(azimuth), std::sin(azimuth), 0);
    const Vector3f root = out * 0.3f * radius + Vector3f(0, 0, 0.9f * pot);
    const Vector3f tip = out * reach + Vector3f(0, 0, top);
    const Vector3f knee =
        0.5f * (root + tip) + Vector3f(0, 0, 0.12f * height_m) - 0.3f * reach * out;
    const auto path = SmoothPath({root, knee, tip}, 4);
    AddTube(body.mesh, stalk, path, {0.004f}, 6);
    const int leaves = 3 + static_cast<int>(random.Index(3));
    for (int k = 0; k < leaves; ++k) {
      const auto at = static_cast<std::size_t>(
          static_cast<float>(path.size() - 1) *
          (0.45f + 0.55f * static_cast<float>(k + 1) / static_cast<float>(leaves)));
      const float width_m = height_m * Between(random, 0.07f, 0.11f),
                  leaf_m = height_m * Between(random, 0.18f, 0.30f),
                  elevation = Between(random, 0.1f, 0.9f),
                  turned = azimuth + Between(random, -1.3f, 1.3f);
      AddLeaf(body.mesh, leaf, path[at], turned, elevation, leaf_m, width_m);
    }
  }
  return body;
}

PaintedBody Vase(Random& random) {
  PaintedBody body;
  const float s = Between(random, 0.8f, 1.2f);
  const int glaze = body.Paint({.color = CeramicColor(random), .gloss = 0.05f, .roughness = 0.08f});
  std::vector<Vector2f> profile = {{0, 0},          {0.04f, 0},     {0.055f, 0.02f},
                                   {0.075f, 0.07f}, {0.07f, 0.12f}, {0.045f, 0.17f},
                                   {0.028f, 0.20f}, {0.03f, 0.23f}, {0.026f, 0.23f},
                                   {0.022f, 0.20f}, {0, 0.19f}};
  for (Vector2f& p : profile) p *= s;
  AddLathe(body.mesh, glaze, {0, 0, 0}, profile, 28);
  const int stalk = body.Paint({.color = ColorFromHex(0x6a7a48)});
  const int petal = body.Paint({.pattern = Pattern::kLeaf,
                                .color = ColorFromHex(random.Uniform() < 0.5 ? 0xd98e73 : 0xe5c45f),
                                .accent = ColorFromHex(0xf0e0c0),
                                .seed = 3});
  const int heart = body.Paint({.color = ColorFromHex(0x7a5326)});
  for (int i = 0; i < 6; ++i) {
    const float azimuth = Between(random, 0, 2 * kPiF), reach = Between(random, 0.04f, 0.12f) * s;
    const Vector3f out(std::cos(azimuth), std::sin(azimuth), 0);
    const Vector3f tip = out * reach + Vector3f(0, 0, Between(random, 0.36f, 0.5f) * s);
    AddTube(body.mesh, stalk,
            SmoothPath({{0, 0, 0.2f * s}, 0.35f * out * reach + Vector3f(0, 0, 0.32f * s), tip}, 3),
            {0.002f}, 5);
    for (int k = 0; k < 8; ++k) {
      AddLeaf(body.mesh, petal, tip, 2 * kPiF * static_cast<float>(k) / 8 + azimuth,
              0.7f + 0.25f * static_cast<float>(k % 2), 0.036f * s, 0.02f * s);
    }
    AddLathe(body.mesh, heart, tip + Vector3f(0, 0, 0.004f),
             {{0, -0.006f}, {0.008f, -0.004f}, {0.009f, 0.003f}, {0, 0.007f}}, 10);
  }
  return body;
}

PaintedBody Bowl(Random& random) {
  PaintedBody body;
  const int glaze = body.Paint({.color = CeramicColor(random), .gloss = 0.05f, .roughness = 0.1f});
  AddLathe(body.mesh, glaze, {0, 0, 0},
           {{0, 0},
            {0.05f, 0},
            {0.09f, 0.025f},
            {0.13f, 0.075f},
            {0.124f, 0.075f},
            {0.085f, 0.03f},
            {0, 0.012f}},
           32);
  constexpr std::array<std::uint32_t, 3> kFruits = {0xc2452f, 0xd9912e, 0x8fa544};
  for (int i = 0; i < 4; ++i) {
    const float angle = kPiF / 2 * static_cast<float>(i) + Between(random, -0.2f, 0.2f);
    const Vector3f at(0.052f * std::cos(angle), 0.052f * std::sin(angle), 0.058f);
    const int skin = body.Paint({.pattern = Pattern::kPlaster,
                                 .color = ColorFromHex(kFruits[random.Index(3)]),
                                 .gloss = 0.03f});
    std::vector<Vector2f> ball;
    for (int k = 0; k <= 8; ++k) {
      const float t = kPiF * static_cast<float>(k) / 8;
      ball.emplace_back(0.036f * std::sin(t), -0.034f * std::cos(t));
    }
    AddLathe(body.mesh, skin, at, ball, 16);
  }
  return body;
}

PaintedBody Mug(Random& random) {
  PaintedBody body;
  const int glaze = body.Paint({.color = CeramicColor(random), .gloss = 0.05f, .roughness = 0.1f});
  AddLathe(body.mesh, glaze, {0, 0, 0},
           {{0, 0},
            {0.036f, 0},
            {0.039f, 0.006f},
            {0.04f, 0.095f},
            {0.036f, 0.095f},
            {0.035f, 0.012f},
            {0, 0.01f}},
           24);
  AddTube(
      body.mesh, glaze,
      SmoothPath(
          {{0.036f, 0, 0.08f}, {0.062f, 0, 0.075f}, {0.066f, 0, 0.045f}, {0.038f, 0, 0.022f}}, 5),
      {0.005f}, 8);
  return body;
}

PaintedBody CardboardBox(const Vector3f& size_m, Random& random) {
  PaintedBody body;
  const int card = body.Paint({.pattern = Pattern::kCardboard,
                               .color = ColorFromHex(0xb58d5f),
                               .seed = random.Bits() % 1000});
  const int tape = body.Paint({.color = ColorFromHex(0xc9b48a), .gloss = 0.05f});
  AddBlock(body.mesh, card, {0, 0, size_m.z() / 2}, size_m, 0.004f);
  AddBlock(body.mesh, tape, {0, 0, size_m.z()}, {size_m.x() * 1.003f, 0.05f, 0.002f}, 0.0005f);
  return body;
}

PaintedBody Basket(Random& random) {
  PaintedBody body;
  const int wicker = body.Paint({.pattern = Pattern::kWeave,
                                 .color = ColorFromHex(0xb9925f),
                                 .accent = ColorFromHex(0x6e4f2e),
                                 .scale = 4,
                                 .seed = random.Bits() % 1000});
  AddLathe(body.mesh, wicker, {0, 0, 0},
           {{0, 0},
            {0.17f, 0},
            {0.19f, 0.02f},
            {0.22f, 0.18f},
            {0.21f, 0.34f},
            {0.195f, 0.34f},
            {0.205f, 0.18f},
            {0.17f, 0.03f},
            {0, 0.03f}},
           32);
  const Vector3f tone = CeramicColor(random);
  const int blanket =
      body.Paint({.pattern = Pattern::kWeave, .color = tone, .accent = tone * 0.6f, .scale = 2});
  AddCushion(body.mesh, blanket, {0, 0, 0.29f}, {0.30f, 0.26f, 0.16f}, 0.3f, TurnZ(0.5f));
  return body;
}

PaintedBody Laptop() {
  PaintedBody body;
  const int metal =
      body.Paint({.color = ColorFromHex(0x9a9da0), .gloss = 0.08f, .roughness = 0.25f});
  const int keys = body.Paint({.color = ColorFromHex(0x2a2b2d)});
  AddBlock(body.mesh, metal, {0, 0, 0.009f}, {0.22f, 0.32f, 0.016f}, 0.006f);
  AddBlock(body.mesh, keys, {0.0f, 0, 0.0172f}, {0.10f, 0.27f, 0.002f}, 0.001f);
  const Matrix3f lean = Eigen::AngleAxisf(-0.35f, Vector3f::UnitY()).toRotationMatrix();
  AddBox(body.mesh, metal,
         {.center = Vector3f(-0.11f, 0, 0.018f) + lean * Vector3f(0, 0, 0.105f),
          .size = {0.007f, 0.32f, 0.21f},
          .radius = 0.003f,
          .rotation = lean});
  const int screen = body.Paint({.pattern = Pattern::kScreen,
                                 .accent = {0.7f, 0.75f, 0.8f},
                                 .gloss = 0.04f,
                                 .roughness = 0.05f,
                                 .emission = 0.7f,
                                 .extent = {0.30f, 0.19f},
                                 .seed = 17});
  AddBox(body.mesh, screen,
         {.center = Vector3f(-0.11f, 0, 0.018f) + lean * Vector3f(0.0038f, 0, 0.107f),
          .size = {0.002f, 0.30f, 0.19f},
          .radius = 0.0005f,
          .rotation = lean,
          .grain = 1});
  return body;
}

PaintedBody Pillow(Random& random) {
  PaintedBody body;
  constexpr std::array<std::uint32_t, 5> kColors = {0xd9a441, 0xe8dfcd, 0x9c4f3d, 0x3e5c66,
                                                    0x7d8b6a};
  const Vector3f tone = ColorFromHex(kColors[random.Index(kColors.size())]);
  const int cloth =
      body.Paint({.pattern = random.Uniform() < 0.5 ? Pattern::kDots : Pattern::kWeave,
                  .color = tone,
                  .accent = tone * 0.6f,
                  .seed = random.Bits() % 1000});
  const Matrix3f lean = Eigen::AngleAxisf(-0.42f, Vector3f::UnitY()).toRotationMatrix();
  AddCushion(body.mesh, cloth, {0, 0, 0.20f}, {0.12f, 0.42f, 0.40f}, 0.5f, lean);
  return body;
}

PaintedBody FramedPicture(float width_m, float height_m, Random& random) {
  PaintedBody body;
  constexpr std::array<std::uint32_t, 6> kSkies = {0x9db8bf, 0xd9b48f, 0x86a3a0,
                                                   0xc7a9a0, 0xa8b59a, 0xcabf9f};
  constexpr std::array<std::uint32_t, 6> kLands = {0x2f4a50, 0x6b3f2c, 0x30453a,
                                                   0x553646, 0x37402c, 0x27384d};
  const std::uint32_t pick = random.Index(6);
  const int frame =
      body.Paint({.pattern = Pattern::kWood,
                  .color = ColorFromHex(random.Uniform() < 0.5 ? 0x2b2825 : 0xb48a58),
                  .accent = ColorFromHex(random.Uniform() < 0.5 ? 0x1c1a18 : 0x8a6337),
                  .gloss = 0.04f});
  const int canvas = body.Paint({.pattern = Pattern::kPicture,
                                 .color = ColorFromHex(kSkies[pick]),
                                 .accent = ColorFromHex(kLands[pick]),
                                 .gloss = 0.02f,
                                 .roughness = 0.1f,
                                 .extent = {width_m, height_m},
                                 .seed = random.Bits() % 10000});
  AddBox(body.mesh, canvas,
         {.center = {0.008f, 0, 0},
          .size = {0.012f, width_m, height_m},
          .radius = 0.001f,
          .grain = 1});
  for (const float side : {-1.0f, 1.0f}) {
    AddBlock(body.mesh, frame, {0.0125f, side * (width_m / 2 + 0.008f), 0},
             {0.025f, 0.022f, height_m + 0.038f}, 0.003f);
    AddBlock(body.mesh, frame, {0.0125f, 0, side * (height_m / 2 + 0.008f)},
             {0.025f, width_m, 0.022f}, 0.003f);
  }
  return body;
}

PaintedBody WallShelf(float length_m, Random& random) {
  PaintedBody body;
  const int wood = body.Paint({.pattern = Pattern::kWood,
                               .color = ColorFromHex(0xb98d5c),
                               .accent = ColorFromHex(0x8a6036),
                               .gloss = 0.03f});
  AddBlock(body.mesh, wood, {0.11f, 0, -0.0125f}, {0.22f, length_m, 0.025f}, 0.004f);
  const auto put = [&](const PaintedBody& thing, float y) {
    const int offset = static_cast<int>(body.materials.size());
    body.materials.insert(body.materials.end(), thing.materials.begin(), thing.materials.end());
    AppendPainted(thing.mesh, Eigen::Isometry3f(Eigen::Translation3f(0.11f, y, 0)), offset,
                  body.mesh);
  };
  const float books = 0.5f * length_m;
  put(BookRow(books, random), -length_m / 2 + books / 2 + 0.03f);
  put(Vase(random), 0.12f * length_m);
  put(PottedPlant(0.3f, random), 0.36f * length_m);
  return body;
}

PaintedBody Rug(float depth_m, float width_m, const Vector3f& color, const Vector3f& accent,
                std::uint32_t seed) {
  PaintedBody body;
  const int pile = body.Paint({.pattern = Pattern::kRug,
                               .color = color,
                               .accent = accent,
                               .extent = {depth_m, width_m},
                               .seed = seed});
  AddBox(
      body.mesh, pile,
      {.center = {0, 0, 0.006f}, .size = {depth_m, width_m, 0.012f}, .radius = 0.005f, .grain = 0});
  return body;
}

PaintedBody Curtain(float width_m, float height_m, const Vector3f& color, std::uint32_t seed) {
  PaintedBody body;
  const int cloth = body.Paint(
      {.pattern = Pattern::kWeave, .color = color, .accent = color * 0.8f, .seed = seed});
  AddBox(body.mesh, cloth,
         {.center = {0.09f, 0, height_m / 2 + 0.015f},
          .size = {0.012f, width_m, height_m},
          .radius = 0.004f,
          .divisions = {1, 60, 4},
          .grain = 2});
  Deform(body.mesh, 0, [&](const Vector3f& p) {
    const float loose = 0.6f + 0.4f * (1 - p.z() / height_m);
    return Vector3f(p.x() + 0.032f * loose * std::sin(p.y() * 62 + 0.7f * std::sin(9 * p.y())),
                    p.y() * (0.94f + 0.06f * loose), p.z());
  });
  return body;
}

PaintedBody Door(const Material& paint) {
  PaintedBody body;
  const int leaf = body.Paint(paint);
  const int metal = body.Paint({.color = ColorFromHex(0x8f8f8c), .gloss = 0.2f, .roughness = 0.1f});
  AddBlock(body.mesh, leaf, {0.012f, 0, 1.0f}, {0.024f, 0.86f, 2.0f}, 0.004f, 2);
  for (const float z : {0.55f, 1.45f}) {
    AddBlock(body.mesh, leaf, {0.024f, 0, z}, {0.014f, 0.6f, 0.7f}, 0.006f, 2);
  }
  for (const float side : {-1.0f, 1.0f}) {
    AddBlock(body.mesh, leaf, {0.018f, side * 0.475f, 1.03f}, {0.036f, 0.085f, 2.06f}, 0.006f, 2);
  }
  AddBlock(body.mesh, leaf, {0.018f, 0, 2.045f}, {0.036f, 0.865f, 0.085f}, 0.006f, 1);
  AddTube(body.mesh, metal,
          SmoothPath({{0.02f, 0.36f, 1.02f},
                      {0.07f, 0.36f, 1.02f},
                      {0.075f, 0.34f, 1.02f},
                      {0.075f, 0.24f, 1.02f}},
                     4),
          {0.009f}, 10);
  return body;
}

}  // namespace plumbline
