// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/places.h"

#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <string>

#include "engine/geometry/angles.h"
#include "engine/synthetic/decor.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
constexpr double kPi = std::numbers::pi;
constexpr double kChairSpacingM = 0.55;

Vector2d Around(const Vector2d& center, double radius_x, double radius_y, double angle_rad) {
  return center + Vector2d(radius_x * std::cos(angle_rad), radius_y * std::sin(angle_rad));
}

/// Adds an arc from one angle to another (turning clockwise where `to` is less), a point every
/// 15 degrees or so.
void AddArc(const Vector2d& center, const Vector2d& radii, double from_deg, double to_deg,
            const Vector2d& look_at, WalkPlan& walk) {
  const int steps = static_cast<int>(std::ceil(std::abs(to_deg - from_deg) / 15));
  for (int i = 0; i <= steps; ++i) {
    const double angle = (from_deg + (to_deg - from_deg) * i / steps) * kRadPerDeg;
    walk.route.push_back({Around(center, radii.x(), radii.y(), angle), look_at});
  }
}

std::string DrawOf(Furnisher& furnisher, std::span<const char* const> names) {
  return names[furnisher.random().Index(static_cast<std::uint32_t>(names.size()))];
}

// Of the corridors round the block in the scene `revisit`.
constexpr double kBlockX = 9.5, kBlockY = 1.9, kCorridorY = 3.3;

/// A wall across the corridor with a doorway of 1.4 m; `side` is -1 or 1.
void BuildDoorway(const RoomStyle& style, double x, double side, Room& room) {
  constexpr double kHalf = 0.7;
  const double outer = room.size.y() / 2;
  const auto at = [&](double y) { return Vector2d(x, side * y); };
  BuildPartition(style, {at(kBlockY), at(kCorridorY - kHalf)}, room);
  BuildPartition(style, {at(kCorridorY + kHalf), at(outer)}, room);
  BuildPartition(style, {at(kCorridorY - kHalf), at(kCorridorY + kHalf), 0.12, 2.12}, room);
}

}  // namespace

void FurnishDividedRoom(Furnisher& furnisher) {
  Room& room = furnisher.room();
  RoomStyle& style = furnisher.style();
  room.size = {9.0, 6.6, 2.6};
  style.window_wall = 2;
  style.accent_wall_index = 3;
  style.lamps = {{-2.2f, 0.0f}, {2.4f, 0.0f}};
  BuildShell(style, room);
  const double wall_x = 0.3, wall_end = 0.6;
  BuildPartition(style, {{wall_x, -room.size.y() / 2}, {wall_x, wall_end}}, room);

  const Vector2d chair(-1.9, -0.9);
  constexpr std::array<const char*, 4> kChairs = {"chair_slat", "chair_slat_arms", "chair_shell",
                                                  "chair_office"};
  const double azimuth = furnisher.Draw(-kPi, kPi);
  furnisher.Place(DrawOf(furnisher, kChairs), Upright(chair.x(), chair.y(), 0, azimuth));
  room.main_instance = 1;
  const Isometry3d south = RoomFromWall(room, 3);  // its y points to -x
  furnisher.Place("sofa_small", south * Upright(0.47, 2.1, 0, furnisher.Draw(-0.04, 0.04)));
  furnisher.Place("lamp_floor", south * Upright(0.36, 3.6, 0, furnisher.Draw(-kPi, kPi)));
  furnisher.HangPictures(south, 1.2, 3.1, 1.55);
  furnisher.HangPictures(Upright(wall_x - 0.06, -1.4, 0, kPi), -1.5, 1.4, 1.5);
  furnisher.WindowWall(style.window_wall);

  // The other half: things without a model stand between the walker and the wall.
  const Isometry3d behind = Upright(wall_x + 0.06, -1.4, 0, 0);
  furnisher.HangPictures(behind, -1.6, -0.2, 1.5);
  furnisher.Decorate(WallShelf(1.2f, furnisher.random()), behind * Upright(0, 0.7, 1.3, 0), 0.02f);
  furnisher.DecorateFloor(PottedPlant(0.9f, furnisher.random()), behind * Upright(0.3, -1.5, 0, 0),
                          0.06f);
  furnisher.DecorateFloor(Basket(furnisher.random()), behind * Upright(0.3, 0.2, 0, 1));
  furnisher.DecorateFloor(CardboardBox({0.3f, 0.42f, 0.26f}, furnisher.random()),
                          behind * Upright(0.25, 0.9, 0, 0.1));
  furnisher.SideboardWall(0);
  furnisher.DoorWall(1);

  WalkPlan& walk = room.walk;
  walk.eye_height_m = furnisher.Draw(1.4, 1.52);
  walk.focus_height_m = 0.7;
  walk.speed_m_s = 0.42;
  // Round the chair and back, nearer; out through the opening; four and a half rounds behind the
  // wall; in again.
  AddArc(chair, {2.0, 2.0}, 70, 110, chair, walk);
  AddArc(chair, {2.05, 2.0}, 125, 185, chair, walk);
  AddArc(chair, {1.25, 1.3}, 175, 60, chair, walk);
  for (const Vector2d& stand : {Vector2d(-0.5, 0.7), Vector2d(-0.1, 1.3), Vector2d(0.5, 1.55),
                                Vector2d(1.05, 1.2), Vector2d(1.35, 0.4)})
    walk.route.push_back({stand, chair});
  AddArc({2.25, -0.9}, {0.85, 1.1}, 180, 180 + 4 * 360 + 180, chair, walk);
  for (const Vector2d& stand : {Vector2d(3.0, 0.0), Vector2d(2.7, 0.9), Vector2d(1.9, 1.5),
                                Vector2d(1.1, 1.8), Vector2d(0.3, 1.85), Vector2d(-0.5, 1.6)})
    walk.route.push_back({stand, chair});
}

void FurnishSeminarRoom(Furnisher& furnisher) {
  Room& room = furnisher.room();
  RoomStyle& style = furnisher.style();
  room.size = {8.8, 7.6, 2.8};
  style.window_wall = 1;
  style.accent_wall_index = 0;
  style.lamps = {{-1.6f, 0.0f}, {1.9f, 0.0f}};
  BuildShell(style, room);
  constexpr std::array<const char*, 2> kChairs = {"chair_slat", "chair_shell"};
  const std::string chair = DrawOf(furnisher, kChairs);
  for (int row = 0; row < 3; ++row) {
    for (int seat = 0; seat < 4; ++seat) {
      const double azimuth = furnisher.Draw(-1, 1) * 3 * kRadPerDeg,
                   x = (row - 1) * 0.95 + furnisher.Draw(-0.01, 0.01);
      furnisher.Place(chair, Upright(x, (seat - 1.5) * kChairSpacingM, 0, azimuth));
    }
  }
  const double table_azimuth = furnisher.Draw(-0.1, 0.1), table_y = furnisher.Draw(1.3, 1.7);
  furnisher.Place("table_rectangular", Upright(3.0, table_y, 0, table_azimuth));
  furnisher.SideboardWall(0);
  furnisher.DoorWall(2);
  furnisher.HangPictures(RoomFromWall(room, 3), -3.2, 3.2, 1.55);
  furnisher.WindowWall(1);
  WalkPlan& walk = room.walk;
  walk.eye_height_m = furnisher.Draw(1.42, 1.54);
  walk.focus_height_m = 0.7;
  walk.radius_m = 2.4;
  walk.start_angle_rad = furnisher.Draw(-kPi, kPi);
  walk.sweep_rad = furnisher.Chance(0.5) ? 2 * kPi : -2 * kPi;
  walk.speed_m_s = 0.5;
}

void FurnishRoundCorridor(Furnisher& furnisher) {
  Room& room = furnisher.room();
  RoomStyle& style = furnisher.style();
  room.size = {32.0, 9.2, 2.6};
  style.window_wall = 0;
  style.accent_wall_index = 2;
  style.lamps = {{-12.9f, -1.9f}, {-12.9f, 1.9f}, {12.9f, 0.0f}};
  for (const float x : {-7.2f, -2.4f, 2.4f, 7.2f}) {
    for (const float side : {-1.0f, 1.0f})
      style.lamps.emplace_back(x, side * static_cast<float>(kCorridorY));
  }
  BuildShell(style, room);
  BuildPartition(style, {{-kBlockX, 0}, {kBlockX, 0}, 2 * kBlockY}, room);
  for (const double x : {-kBlockX + 0.06, kBlockX - 0.06}) {
    for (const double side : {-1.0, 1.0}) BuildDoorway(style, x, side, room);
  }

  const Vector2d home(-13.1, 0), away(12.9, 0);
  furnisher.ArrangeDining(home);
  const Isometry3d block_west = Upright(-kBlockX, 0, 0, kPi);
  furnisher.Place("sofa_small", block_west * Upright(0.47, furnisher.Draw(-0.5, 0.5), 0, 0));
  furnisher.HangPictures(block_west, -1.4, 1.4, 1.6);
  furnisher.HangPictures(RoomFromWall(room, 2), -2.5, 2.5, 1.5);
  furnisher.Place("bookshelf",
                  RoomFromWall(room, 2) * Upright(0.17, furnisher.Draw(3.2, 3.8), 0, 0));
  furnisher.DecorateFloor(PottedPlant(1.2f, furnisher.random()), Upright(-15.5, 4.0, 0, 0), 0.06f);

  furnisher.ArrangeDining(away);
  furnisher.WindowWall(0);
  const Isometry3d block_east = Upright(kBlockX, 0, 0, 0);
  furnisher.Place("cabinet_doors", block_east * Upright(0.29, furnisher.Draw(-0.5, 0.5), 0, 0));

  // Doors and pictures along both corridors, on both sides.
  const std::array<Isometry3d, 4> faces = {Upright(0, kBlockY, 0, kPi / 2),
                                           Upright(0, -kBlockY, 0, -kPi / 2), RoomFromWall(room, 1),
                                           RoomFromWall(room, 3)};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    for (const double y : {-6.5, -1.5, 4.0}) {
      const double at = y + furnisher.Draw(-0.5, 0.5);
      furnisher.Decorate(Door(style.trim), faces[i] * Upright(0, at, 0, 0), 0.04f);
      furnisher.HangPictures(faces[i], at + 0.9, at + 2.4, 1.5);
    }
    const Isometry3d corner = faces[i] * Upright(0.3, furnisher.Draw(6.8, 8.6), 0, 0);
    const PaintedBody plant =
        PottedPlant(static_cast<float>(furnisher.Draw(0.8, 1.2)), furnisher.random());
    Footprint pot = FootprintOf(plant.mesh, corner);
    pot.half_size = {0.2, 0.2};
    if (furnisher.Reserve(pot)) furnisher.Decorate(plant, corner, 0.06f);
  }
  furnisher.Place("bookshelf", faces[2] * Upright(0.17, furnisher.Draw(-4.6, -4.2), 0, 0));
  furnisher.Place("cabinet_doors", faces[1] * Upright(0.29, furnisher.Draw(1.3, 1.8), 0, 0));
  furnisher.Place("stool_round", faces[3] * Upright(0.35, furnisher.Draw(0.9, 1.3), 0, 0));

  WalkPlan& walk = room.walk;
  walk.eye_height_m = furnisher.Draw(1.4, 1.54);
  walk.focus_height_m = 0.85;
  walk.speed_m_s = 0.335;
  const auto ahead = [&](double from_x, double to_x, double y) {
    const double way = to_x > from_x ? 1 : -1;
    const int steps = static_cast<int>(std::abs(to_x - from_x));
    for (int i = 0; i <= steps; ++i) {
      const double x = from_x + way * i;
      walk.route.push_back({{x, y}, {x + 3.5 * way, 0.97 * y}});
    }
  };
  // Three quarters round the table at home, away and round the other one, and home again. All
  // clockwise.
  AddArc(home, {2.0, 2.0}, 0, -280, home, walk);
  walk.route.push_back({{-11.7, 2.6}, {-10.5, 1.5}});
  walk.route.push_back({{-10.8, 3.15}, {-8.0, 2.6}});
  ahead(-10.0, 9.6, kCorridorY);
  walk.route.push_back({{10.5, 3.2}, away});
  walk.route.push_back({{11.5, 2.7}, away});
  AddArc(away, {2.05, 2.05}, 105, 105 - 360 - 210, away, walk);
  walk.route.push_back({{11.3, -2.7}, {10.5, -1.5}});
  walk.route.push_back({{10.6, -3.15}, {8.0, -2.6}});
  ahead(9.8, -9.4, -kCorridorY);
  walk.route.push_back({{-10.4, -3.2}, home});
  walk.route.push_back({{-11.6, -2.7}, home});
  AddArc(home, {2.0, 2.0}, -100, -345, home, walk);
}

void FurnishOffice(Furnisher& furnisher) {
  Room& room = furnisher.room();
  RoomStyle& style = furnisher.style();
  room.catalogue = OfficeCatalogue(furnisher.palette());
  room.size = {furnisher.Draw(7.4, 7.9), furnisher.Draw(6.6, 7.0), 2.7};
  BuildShell(style, room);
  const auto wall = [&](int turn) { return RoomFromWall(room, (style.window_wall + turn) % 4); };
  const auto half = [&](int turn) { return WallLength(room, (style.window_wall + turn) % 4) / 2; };

  // Two desks face to face, each with a chair, a screen and a pedestal at its end.
  const double bench_azimuth = furnisher.Draw(-kPi, kPi), bench_y = furnisher.Draw(-0.2, 0.2),
               bench_x = furnisher.Draw(-0.2, 0.2);
  const Isometry3d bench = Upright(bench_x, bench_y, 0, bench_azimuth);
  const double depth = furnisher.Size("desk_straight").x(),
               top = furnisher.Size("desk_straight").z();
  const char* const seats[] = {"chair_office", "chair_visitor"};
  for (int i = 0; i < 2; ++i) {
    const Isometry3d desk = bench * Upright(0, 0, 0, i * kPi) * Upright(depth / 2 + 0.02, 0, 0, 0);
    const int index = furnisher.Place("desk_straight", desk);
    const double seat_azimuth = kPi + furnisher.Draw(-0.5, 0.5),
                 seat_y = furnisher.Draw(-0.25, 0.25),
                 seat_x = depth / 2 + furnisher.Draw(0.30, 0.5);
    furnisher.Place(seats[i], desk * Upright(seat_x, seat_y, 0, seat_azimuth), index);
    const double screen_azimuth = furnisher.Draw(-0.1, 0.1), screen_y = furnisher.Draw(-0.15, 0.15);
    furnisher.PlaceOnTop("monitor_desk", desk * Upright(-0.18, screen_y, top, screen_azimuth));
    furnisher.Decorate(Mug(furnisher.random()), desk * Upright(0.2, -0.55, top, 1), 0.015f);
    const Isometry3d books = desk * Upright(-0.05, -0.6, top, furnisher.Draw(-0.4, 0.4));
    furnisher.Decorate(BookStack(3, furnisher.random()), books, 0.015f);
  }
  furnisher.PlaceOnTop("plant_small", bench * Upright(0.25, 0.62, top, furnisher.Draw(-kPi, kPi)));
  furnisher.Place("pedestal_drawers", bench * Upright(0.32, 1.10, 0, furnisher.Draw(-0.1, 0.1)));

  // Opposite the window: shelves. To its sides: a small desk with a door beside it, and a door.
  const Isometry3d back = wall(2);
  const Isometry3d tall = back * Upright(0.21, furnisher.Draw(-0.9, -0.7), 0, 0);
  furnisher.Place("shelf_tall", tall);
  for (const double z : {0.811, 1.191, 1.571})
    furnisher.Decorate(BookRow(static_cast<float>(furnisher.Draw(0.4, 0.7)), furnisher.random()),
                       tall * Upright(-0.03, 0, z, 0), 0.03f);
  const Isometry3d cubes = back * Upright(0.21, furnisher.Draw(0.3, 0.5), 0, 0);
  furnisher.Place("shelf_cubes", cubes);
  for (const double z : {0.038, 0.395}) {
    const Isometry3d row = cubes * Upright(0, furnisher.Chance(0.5) ? 0.18 : -0.18, z, 0);
    furnisher.Decorate(BookRow(0.28f, furnisher.random()), row, 0.03f);
  }
  const double plant_azimuth = furnisher.Draw(-kPi, kPi), plant_y = furnisher.Draw(-0.2, 0.2);
  furnisher.PlaceOnTop(
      "plant_small", cubes * Upright(0, plant_y, furnisher.Size("shelf_cubes").z(), plant_azimuth));
  furnisher.Place("plant_tall", back * Upright(0.5, half(2) - 0.55, 0, furnisher.Draw(-kPi, kPi)));

  const Isometry3d left = wall(1), right = wall(3);
  const Isometry3d side_desk = left * Upright(0.34, furnisher.Draw(-0.4, 0.4), 0, 0);
  const int side_index = furnisher.Place("desk_drawers", side_desk);
  const double visitor_azimuth = kPi + furnisher.Draw(-0.4, 0.4),
               visitor_y = furnisher.Draw(-0.2, 0.2);
  furnisher.Place("chair_visitor", side_desk * Upright(0.62, visitor_y, 0, visitor_azimuth),
                  side_index);
  furnisher.Decorate(Laptop(), side_desk * Upright(0.05, 0.1, 0.75, furnisher.Draw(-0.2, 0.2)),
                     0.015f);
  furnisher.HangPictures(left, -1.0, 1.2, 1.55);
  furnisher.Decorate(Door(style.trim), right * Upright(0, half(3) - 0.9, 0, 0), 0.04f);
  furnisher.HangPictures(right, -half(3) + 0.5, half(3) - 1.7, 1.55);
  furnisher.Place("plant_tall",
                  wall(0) * Upright(0.5, half(0) - 0.6, 0, furnisher.Draw(-kPi, kPi)));
  const double box_azimuth = furnisher.Draw(-0.3, 0.3), box_y = furnisher.Draw(-1.5, 0);
  furnisher.DecorateFloor(CardboardBox({0.32f, 0.44f, 0.28f}, furnisher.random()),
                          right * Upright(0.3, box_y, 0, box_azimuth));

  WalkPlan& walk = room.walk;
  walk.focus = bench.translation().head<2>();
  walk.start_angle_rad = furnisher.Draw(-kPi, kPi);
  walk.eye_height_m = furnisher.Draw(1.42, 1.55);
  walk.focus_height_m = 0.9;
  walk.radius_m = 2.2;
  walk.sweep_rad = furnisher.Chance(0.5) ? 2 * kPi : -2 * kPi;
  walk.speed_m_s = 0.6;
}

void FurnishPlatformRoom(Furnisher& furnisher) {
  Room& room = furnisher.room();
  RoomStyle& style = furnisher.style();
  room.size = {8.6, 6.4, 2.9};
  style.window_wall = 1;
  style.accent_wall_index = 0;
  style.lamps = {{-1.8f, 0.0f}, {2.2f, 0.0f}};
  BuildShell(style, room);
  constexpr double kEdge = 0.6, kHeight = 0.3;
  const int platform = BuildPlatform(style, kEdge, kHeight, room);
  // Somewhere along y, turned by up to `turn` from an azimuth.
  const auto somewhere = [&](double x, double least_y, double most_y, double azimuth, double turn) {
    const double turned = azimuth + furnisher.Draw(-turn, turn);
    return Upright(x, furnisher.Draw(least_y, most_y), kHeight, turned);
  };

  constexpr std::array<const char*, 3> kChairs = {"chair_slat", "chair_shell", "chair_office"};
  const double table_azimuth = furnisher.Draw(-0.15, 0.15), table_y = furnisher.Draw(-0.15, 0.15);
  const Isometry3d table = Upright(-0.75, table_y, 0, table_azimuth);
  const int index = furnisher.Place("table_rectangular", table);
  for (const double side : {1.0, -1.0}) {
    const double azimuth = -side * kPi / 2 + furnisher.Draw(-0.3, 0.3);
    furnisher.Place(DrawOf(furnisher, kChairs),
                    table * Upright(side > 0 ? 0.1 : -0.05, side * 1.05, 0, azimuth), index);
  }

  const Isometry3d chair = somewhere(1.3, -1.5, -1.2, 0, kPi);
  furnisher.Place(DrawOf(furnisher, kChairs), chair, platform);
  furnisher.Place("table_coffee", somewhere(1.7, 0.2, 0.4, 0, 0.2), platform);
  furnisher.Place("stool_round", somewhere(1.4, 1.5, 1.8, 0, kPi), platform);
  furnisher.Place("sofa_small", somewhere(2.9, 0.1, 0.3, kPi, 0.05), platform);
  furnisher.Place("bookshelf",
                  Upright(room.size.x() / 2 - 0.17, furnisher.Draw(-2.3, -2.0), kHeight, kPi),
                  platform);
  furnisher.Place("cabinet_doors",
                  Upright(room.size.x() / 2 - 0.26, furnisher.Draw(1.9, 2.2), kHeight, kPi),
                  platform);
  furnisher.HangPictures(RoomFromWall(room, 0), -1.0, 1.0, 1.7);
  furnisher.HangPictures(RoomFromWall(room, 3), -3.5, 3.5, 1.7);

  // Along the wall round the table and back nearer to it, looking to the edge of the platform.
  WalkPlan& walk = room.walk;
  walk.eye_height_m = furnisher.Draw(1.4, 1.52);
  walk.focus_height_m = 0.6;
  walk.speed_m_s = 0.55;
  const Vector2d edge(0.9, 0);
  AddArc({0.3, 0}, {3.7, 2.6}, 112, 248, edge, walk);
  AddArc({0.3, 0}, {2.7, 2.0}, 240, 120, edge, walk);
}

}  // namespace plumbline
