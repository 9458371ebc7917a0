// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/room_shell.h"

#include <array>
#include <cmath>
#include <numbers>

#include "engine/synthetic/decor.h"
#include "engine/synthetic/furniture_parts.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;
constexpr float kSill = 0.75f, kLintel = 2.25f, kWindowWidth = 2.2f, kReveal = 0.2f;

/// A piece of the wall x = 0 whose texture continues over its neighbours.
void AddWallPiece(PaintedMesh& mesh, int paint, float y0, float z0, float y1, float z1) {
  const std::size_t first = mesh.vertices.size();
  AddQuad(mesh, paint, {0, y0, z0}, {0, y1 - y0, 0}, {0, 0, z1 - z0});
  for (std::size_t i = first; i < mesh.vertices.size(); ++i) {
    mesh.texture[i] = {mesh.vertices[i].y(), mesh.vertices[i].z(), 0};
  }
}

/// Light is computed at a limited number of points on a face, so large ones are cut.
int PiecesOf(float length) {
  constexpr float kLongestPiece = 8;
  return static_cast<int>(std::ceil(length / kLongestPiece));
}

/// A rectangle in pieces whose texture continues.
void AddSurface(PaintedMesh& mesh, int paint, const Vector3f& corner, const Vector3f& u,
                const Vector3f& v) {
  const int across = PiecesOf(u.norm()), up = PiecesOf(v.norm());
  const Vector3f step_u = u / static_cast<float>(across), step_v = v / static_cast<float>(up);
  for (int i = 0; i < across; ++i) {
    for (int j = 0; j < up; ++j) {
      const auto a = static_cast<float>(i), b = static_cast<float>(j);
      const std::size_t first = mesh.vertices.size();
      AddQuad(mesh, paint, corner + a * step_u + b * step_v, step_u, step_v);
      for (std::size_t k = first; k < mesh.vertices.size(); ++k)
        mesh.texture[k] += Vector3f(a * step_u.norm(), b * step_v.norm(), 0);
    }
  }
}

/// A whole wall x = 0, centred on y = 0.
void AddWall(PaintedMesh& mesh, int paint, float length, float bottom, float top) {
  const int pieces = PiecesOf(length);
  for (int i = 0; i < pieces; ++i) {
    const auto at = [&](int k) {
      return length * (static_cast<float>(k) / static_cast<float>(pieces) - 0.5f);
    };
    AddWallPiece(mesh, paint, at(i), bottom, at(i + 1), top);
  }
}

void AddBaseboard(PaintedMesh& mesh, int paint, float length, float gap_from, float gap_to) {
  const auto piece = [&](float from, float to) {
    if (to - from < 0.01f) return;
    AddBlock(mesh, paint, {0.007f, (from + to) / 2, 0.04f}, {0.014f, to - from, 0.08f}, 0.004f, 1);
  };
  piece(-length / 2, gap_from);
  piece(gap_to, length / 2);
}

PaintedBody WindowBody(const Material& wall, const Material& frame) {
  PaintedBody body;
  const int reveal = body.Paint(wall);
  const int paint = body.Paint(frame);
  const float half = kWindowWidth / 2, height = kLintel - kSill;
  AddQuad(body.mesh, reveal, {-kReveal, half, kSill}, {kReveal, 0, 0}, {0, 0, height});
  AddQuad(body.mesh, reveal, {0, -half, kSill}, {-kReveal, 0, 0}, {0, 0, height});
  AddQuad(body.mesh, reveal, {-kReveal, -half, kSill}, {kReveal, 0, 0}, {0, 2 * half, 0});
  AddQuad(body.mesh, reveal, {-kReveal, -half, kLintel}, {0, 2 * half, 0}, {kReveal, 0, 0});
  const float x = -0.14f, bar = 0.055f;
  for (const float y : {-half + bar / 2, -0.04f, 0.04f, half - bar / 2}) {
    AddBlock(body.mesh, paint, {x, y, kSill + height / 2}, {0.05f, bar, height}, 0.006f);
  }
  for (const float z : {kSill + bar / 2, kLintel - bar / 2}) {
    AddBlock(body.mesh, paint, {x, 0, z}, {0.05f, 2 * half, bar}, 0.006f);
  }
  AddBlock(body.mesh, paint, {x, 0, kSill + 0.72f * height}, {0.03f, 2 * half, 0.03f}, 0.005f);
  AddBlock(body.mesh, paint, {0.01f, 0, kSill - 0.012f}, {0.24f, 2 * half + 0.12f, 0.025f}, 0.008f);
  return body;
}

void AddWindow(const RoomStyle& style, Room& room) {
  const Eigen::Isometry3d room_from_wall = RoomFromWall(room, style.window_wall);
  const Eigen::Isometry3f pose = room_from_wall.cast<float>();
  AddDecor(WindowBody(style.walls, style.frame), room_from_wall, 0.03f, room);
  RoomPart view;
  Material outside{.pattern = Pattern::kView,
                   .emission = 3.2f * style.sky_strength / 7,
                   .extent = {14, 6},
                   .seed = 77};
  AddQuad(view.body.mesh, view.body.Paint(outside), pose * Vector3f(-1.6f, -7, -1),
          pose.linear() * Vector3f(0, 14, 0), pose.linear() * Vector3f(0, 0, 6));
  view.lets_light_in = true;
  view.in_scan = false;
  room.parts.push_back(std::move(view));
  room.lights.push_back({pose * Vector3f(-kReveal, -kWindowWidth / 2, kSill),
                         pose.linear() * Vector3f(0, kWindowWidth, 0),
                         pose.linear() * Vector3f(0, 0, kLintel - kSill),
                         style.sky_strength * Vector3f(0.92f, 0.98f, 1.06f)});
  const auto height = style.sun_height_deg * static_cast<float>(std::numbers::pi) / 180,
             side = style.sun_side_deg * static_cast<float>(std::numbers::pi) / 180;
  const Vector3f to_sun(-std::cos(height) * std::cos(side), std::cos(height) * std::sin(side),
                        std::sin(height));
  room.sun =
      SunLight{pose.linear() * to_sun, style.sun_strength * Vector3f(1.0f, 0.86f, 0.66f), 0.028f};
  for (const float end : {-1.0f, 1.0f}) {
    const Eigen::Isometry3d at =
        room_from_wall * Eigen::Translation3d(0, end * (kWindowWidth / 2 + 0.17), 0);
    AddDecor(Curtain(0.5f, 2.38f, style.curtain, 31), at, 0.04f, room);
  }
  PaintedBody rod;
  AddTube(rod.mesh, rod.Paint({.color = ColorFromHex(0x3a3835), .gloss = 0.05f}),
          {{0.09f, -kWindowWidth / 2 - 0.5f, 2.41f}, {0.09f, kWindowWidth / 2 + 0.5f, 2.41f}},
          {0.012f}, 12);
  AddDecor(rod, room_from_wall, 0.05f, room);
}

void AddCeilingLamp(const RoomStyle& style, const Eigen::Vector2f& center, Room& room) {
  const auto height = static_cast<float>(room.size.z());
  PaintedBody lamp;
  const int rim = lamp.Paint(style.trim);
  const int glow =
      lamp.Paint({.color = {1.0f, 0.93f, 0.82f}, .emission = 1.2f * style.lamp_strength});
  AddBlock(lamp.mesh, rim, {0, 0, height - 0.02f}, {0.96f, 0.96f, 0.04f}, 0.015f);
  AddBlock(lamp.mesh, glow, {0, 0, height - 0.042f}, {0.88f, 0.88f, 0.01f}, 0.003f);
  const Eigen::Isometry3d at(Eigen::Translation3d(center.x(), center.y(), 0));
  AddDecor(lamp, at, 0.05f, room);
  room.parts.back().in_scan = false;
  room.lights.push_back({{center.x() - 0.44f, center.y() - 0.44f, height - 0.05f},
                         {0, 0.88f, 0},
                         {0.88f, 0, 0},
                         4.5f * style.lamp_strength * Vector3f(1.0f, 0.90f, 0.74f)});
}

}  // namespace

RoomStyle RandomStyle(const FurniturePalette& palette, Random& random) {
  constexpr std::array<std::uint32_t, 5> kWalls = {0xece7dc, 0xe4e6e2, 0xe9e0d0, 0xdfe3e0,
                                                   0xefebe4};
  constexpr std::array<std::uint32_t, 6> kAccents = {0x9fb0a3, 0xb7a48c, 0x8fa3ad,
                                                     0xc4a58f, 0xa9a795, 0x7f9296};
  const auto between = [&](double low, double high) {
    return static_cast<float>(random.Uniform(low, high));
  };
  RoomStyle style;
  style.walls = {.pattern = Pattern::kPlaster,
                 .color = ColorFromHex(kWalls[random.Index(kWalls.size())]),
                 .seed = 3};
  style.accent_wall = style.walls;
  style.accent_wall.color = ColorFromHex(kAccents[random.Index(kAccents.size())]);
  const double choice = random.Uniform();
  if (choice < 0.25) {
    style.accent_wall.pattern = Pattern::kStripes;
    style.accent_wall.accent = style.accent_wall.color * 0.85f;
  } else if (choice < 0.5) {
    style.accent_wall.pattern = Pattern::kDots;
    style.accent_wall.accent = style.accent_wall.color * 1.25f;
  }
  style.ceiling = {.pattern = Pattern::kPlaster, .color = ColorFromHex(0xf1efea), .seed = 4};
  style.trim = {.color = ColorFromHex(0xf0ede6), .gloss = 0.03f, .roughness = 0.2f};
  style.frame = style.trim;
  const float tone = between(0.75, 1.15);
  style.floor = {.pattern = Pattern::kPlanks,
                 .color = palette.wood.color * tone,
                 .accent = palette.wood.accent * tone,
                 .gloss = 0.035f,
                 .roughness = 0.12f,
                 .seed = random.Bits() % 1000};
  if (random.Uniform() < 0.2) {
    style.floor = {.pattern = Pattern::kTiles,
                   .color = ColorFromHex(0xb9b2a6),
                   .accent = ColorFromHex(0x8f897f),
                   .scale = 1.5f,
                   .gloss = 0.04f,
                   .roughness = 0.1f,
                   .seed = random.Bits() % 1000};
  }
  style.curtain = ColorFromHex(0xd9d2c3) * between(0.75, 1.1);
  style.window_wall = static_cast<int>(random.Index(4));
  style.accent_wall_index = (style.window_wall + 1 + static_cast<int>(random.Index(3))) % 4;
  style.sun_height_deg = between(24, 42);
  style.sun_side_deg = between(-40, 40);
  style.sun_strength = between(4, 8);
  style.sky_strength = between(5, 8);
  style.lamp_strength = between(1.5, 2.4);
  return style;
}

Eigen::Isometry3d RoomFromWall(const Room& room, int wall) {
  const double azimuth = std::numbers::pi + wall * std::numbers::pi / 2;  // of the wall's normal
  const double distance = (wall % 2 == 0 ? room.size.x() : room.size.y()) / 2;
  Eigen::Isometry3d pose(Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()));
  pose.translation() = pose.linear() * Eigen::Vector3d(-distance, 0, 0);
  return pose;
}

double WallLength(const Room& room, int wall) {
  return wall % 2 == 0 ? room.size.y() : room.size.x();
}

void BuildShell(const RoomStyle& style, Room& room) {
  const auto width = static_cast<float>(room.size.x()), depth = static_cast<float>(room.size.y());
  const auto height = static_cast<float>(room.size.z());
  RoomPart floor;
  AddSurface(floor.body.mesh, floor.body.Paint(style.floor), {-width / 2, -depth / 2, 0},
             {width, 0, 0}, {0, depth, 0});
  floor.light_spacing_m = 0.024f;
  room.parts.push_back(std::move(floor));
  RoomPart ceiling;
  AddSurface(ceiling.body.mesh, ceiling.body.Paint(style.ceiling), {-width / 2, -depth / 2, height},
             {0, depth, 0}, {width, 0, 0});
  ceiling.light_spacing_m = 0.08f;
  ceiling.in_scan = false;
  room.parts.push_back(std::move(ceiling));
  for (int wall = 0; wall < 4; ++wall) {
    PaintedBody body;
    const int paint = body.Paint(wall == style.accent_wall_index ? style.accent_wall : style.walls);
    const int trim = body.Paint(style.trim);
    const auto half = static_cast<float>(WallLength(room, wall)) / 2;
    if (wall == style.window_wall) {
      const float opening = kWindowWidth / 2;
      AddWallPiece(body.mesh, paint, -half, 0, -opening, height);
      AddWallPiece(body.mesh, paint, opening, 0, half, height);
      AddWallPiece(body.mesh, paint, -opening, 0, opening, kSill);
      AddWallPiece(body.mesh, paint, -opening, kLintel, opening, height);
    } else {
      AddWall(body.mesh, paint, 2 * half, 0, height);
    }
    AddBaseboard(body.mesh, trim, 2 * half, half, half);
    AddDecor(body, RoomFromWall(room, wall), 0.045f, room);
  }
  AddWindow(style, room);
  for (const Eigen::Vector2f& lamp : style.lamps) AddCeilingLamp(style, lamp, room);
}

void BuildPartition(const RoomStyle& style, const Partition& partition, Room& room) {
  const Eigen::Vector2d along = partition.to - partition.from;
  const double length = along.norm(), thickness = partition.thickness_m;
  const Eigen::Vector2d center = (partition.from + partition.to) / 2;
  const double azimuth = std::atan2(-along.x(), along.y());  // of the face to the right
  const auto bottom = static_cast<float>(partition.bottom_m);
  const auto top = static_cast<float>(room.size.z());
  PaintedBody body;
  const int paint = body.Paint(style.walls), trim = body.Paint(style.trim);
  for (int side = 0; side < 4; ++side) {
    const bool face = side % 2 == 0;
    const auto width = static_cast<float>(face ? length : thickness);
    PaintedMesh wall;
    AddWall(wall, paint, width, bottom, top);
    if (bottom == 0) AddBaseboard(wall, trim, width, width / 2, width / 2);
    const Eigen::Isometry3d pose =
        Eigen::AngleAxisd(side * std::numbers::pi / 2, Eigen::Vector3d::UnitZ()) *
        Eigen::Translation3d((face ? thickness : length) / 2, 0, 0);
    AppendPainted(wall, pose.cast<float>(), 0, body.mesh);
  }
  if (bottom > 0) {
    const auto x = static_cast<float>(thickness / 2), y = static_cast<float>(length / 2);
    AddQuad(body.mesh, paint, {-x, -y, bottom}, {0, 2 * y, 0}, {2 * x, 0, 0});
  } else {
    room.obstacles.push_back({center, {thickness / 2, length / 2}, azimuth});
  }
  AddDecor(body,
           Eigen::Translation3d(center.x(), center.y(), 0) *
               Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()),
           0.045f, room);
}

int BuildPlatform(const RoomStyle& style, double from_x_m, double height_m, Room& room) {
  const auto from = static_cast<float>(from_x_m), height = static_cast<float>(height_m);
  const auto end = static_cast<float>(room.size.x() / 2), depth = static_cast<float>(room.size.y());
  RoomPart platform;
  const int top = platform.body.Paint(style.floor), front = platform.body.Paint(style.trim);
  AddSurface(platform.body.mesh, top, {from, -depth / 2, height}, {end - from, 0, 0},
             {0, depth, 0});
  AddSurface(platform.body.mesh, front, {from, depth / 2, 0}, {0, -depth, 0}, {0, 0, height});
  platform.light_spacing_m = 0.024f;
  room.parts.push_back(std::move(platform));
  const double far = room.size.x() / 2, side = room.size.y() / 2;
  room.levels.push_back({height_m,
                         0,
                         {{from_x_m, -side, height_m},
                          {far, -side, height_m},
                          {far, side, height_m},
                          {from_x_m, side, height_m}}});
  room.obstacles.push_back({{(from_x_m + far) / 2, 0}, {(far - from_x_m) / 2, side}, 0});
  return static_cast<int>(room.obstacles.size()) - 1;
}

void AddDecor(const PaintedBody& body, const Eigen::Isometry3d& room_from_body,
              float light_spacing_m, Room& room) {
  RoomPart part;
  part.body.materials = body.materials;
  AppendPainted(body.mesh, room_from_body.cast<float>(), 0, part.body.mesh);
  part.light_spacing_m = light_spacing_m;
  room.parts.push_back(std::move(part));
}

}  // namespace plumbline
