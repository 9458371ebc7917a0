// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/furniture.h"

#include <array>
#include <cmath>

#include "engine/base/random.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

Material WoodOf(std::uint32_t light, std::uint32_t dark, std::uint32_t seed) {
  return {.pattern = Pattern::kWood,
          .color = ColorFromHex(light),
          .accent = ColorFromHex(dark),
          .gloss = 0.03f,
          .roughness = 0.25f,
          .seed = seed};
}

Material Cloth(std::uint32_t color, std::uint32_t seed) {
  const Vector3f tone = ColorFromHex(color);
  return {.pattern = Pattern::kWeave, .color = tone, .accent = tone * 0.55f, .seed = seed};
}

template <std::size_t N>
std::uint32_t Pick(const std::array<std::uint32_t, N>& colors, Random& random) {
  return colors[random.Index(N)];
}

std::uint8_t Encoded(float linear) {
  return static_cast<std::uint8_t>(std::lround(255 * EncodeSrgb(linear)));
}

}  // namespace

FurniturePalette PaletteOfSeed(std::uint64_t seed) {
  Random random({.seed = seed, .object = 0x50414c});
  struct Wood {
    std::uint32_t light, dark;
  };
  constexpr std::array<Wood, 4> kWoods = {
      {{0xc9a06b, 0x9a6b3a}, {0xd8b78a, 0xb08650}, {0xb9814c, 0x8a5630}, {0xcfa97c, 0x8f6a45}}};
  constexpr std::array<Wood, 3> kDarkWoods = {
      {{0x7a4e30, 0x4f2f1c}, {0x8c5f3c, 0x5d3a22}, {0x6b4a36, 0x433024}}};
  constexpr std::array<std::uint32_t, 6> kFabrics = {0x5f7484, 0x8a8f86, 0xa9784f,
                                                     0x56695a, 0x9b5f4f, 0x6d6a78};
  constexpr std::array<std::uint32_t, 6> kSecondFabrics = {0x3f5a6b, 0x54605c, 0x7a3f35,
                                                           0x4a4f58, 0xb08d3f, 0x496255};
  constexpr std::array<std::uint32_t, 6> kPlastics = {0xe9e4da, 0xd9b23c, 0x2f6f73,
                                                      0xb5523b, 0x8fa7a0, 0xeeeeea};
  constexpr std::array<std::uint32_t, 5> kLacquers = {0xe8e5dd, 0xb9c2bd, 0x6e8488, 0x3f4c52,
                                                      0xcdbfa6};
  // Seed 1 is the built-in demo; its colours are chosen, not drawn.
  const bool demo = seed == 1;
  const Wood wood = demo ? kWoods[0] : kWoods[random.Index(kWoods.size())];
  const Wood dark = demo ? kDarkWoods[0] : kDarkWoods[random.Index(kDarkWoods.size())];
  FurniturePalette palette;
  palette.wood = WoodOf(wood.light, wood.dark, 11);
  palette.dark_wood = WoodOf(dark.light, dark.dark, 12);
  palette.fabric = Cloth(demo ? 0x5f7f8c : Pick(kFabrics, random), 13);
  palette.second_fabric = Cloth(demo ? 0xb4763c : Pick(kSecondFabrics, random), 14);
  palette.metal = {.color = ColorFromHex(random.Uniform() < 0.5 ? 0x3a3c3f : 0x8f9295),
                   .gloss = 0.10f,
                   .roughness = 0.15f};
  palette.plastic = {.color = ColorFromHex(demo ? 0x2f6f73 : Pick(kPlastics, random)),
                     .gloss = 0.04f,
                     .roughness = 0.12f};
  palette.lacquer = {.pattern = Pattern::kPlaster,
                     .color = ColorFromHex(demo ? 0xe8e5dd : Pick(kLacquers, random)),
                     .gloss = 0.03f,
                     .roughness = 0.18f};
  palette.lampshade = {.pattern = Pattern::kWeave,
                       .color = ColorFromHex(0xf3e3c3),
                       .accent = ColorFromHex(0xe0c89b),
                       .emission = 1.1f};
  return palette;
}

std::vector<FurnitureModel> FurnitureCatalogue(const FurniturePalette& palette) {
  return {SlatChair(palette, false),  SlatChair(palette, true), ShellChair(palette),
          OfficeChair(palette, true), RoundStool(palette),      RectangularTable(palette),
          RoundTable(palette),        CoffeeTable(palette),     WideSofa(palette),
          SmallSofa(palette),         DeskMonitor(palette),     WideTv(palette),
          DoorCabinet(palette),       Sideboard(palette),       Bookshelf(palette),
          FloorLamp(palette),         TableLamp(palette)};
}

TriangleMesh DatabaseMesh(const PaintedBody& body) {
  TriangleMesh mesh;
  mesh.vertices = body.mesh.vertices;
  mesh.normals = body.mesh.normals;
  mesh.triangles = body.mesh.triangles;
  mesh.colors.resize(mesh.vertices.size());
  constexpr float kCoarse = 0.05f;  // what is finer than this does not show in vertex colours
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Material& material = body.materials[static_cast<std::size_t>(body.mesh.paints[t])];
    for (int corner = 0; corner < 3; ++corner) {
      const int v = mesh.triangles[t][corner];
      const Vector3f color =
          PatternColor(material, body.mesh.texture[static_cast<std::size_t>(v)], kCoarse);
      mesh.colors[static_cast<std::size_t>(v)] = {Encoded(color.x()), Encoded(color.y()),
                                                  Encoded(color.z())};
    }
  }
  return mesh;
}

}  // namespace plumbline
