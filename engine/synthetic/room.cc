// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/base/check.h"
#include "engine/synthetic/decor.h"
#include "engine/synthetic/furnisher.h"
#include "engine/synthetic/places.h"
#include "engine/synthetic/street.h"
#include "engine/synthetic/walk.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector2d;
constexpr double kRatesSeconds = 15;

void FurnishWalls(Furnisher& furnisher) {
  std::array<int, 3> walls;
  const int turn = furnisher.demo() ? 1 : static_cast<int>(furnisher.random().Index(3));
  for (int i = 0; i < 3; ++i)
    walls[static_cast<std::size_t>(i)] = (furnisher.style().window_wall + 1 + (i + turn) % 3) % 4;
  furnisher.SofaWall(walls[0]);
  furnisher.SideboardWall(walls[1]);
  furnisher.DoorWall(walls[2]);
  furnisher.WindowWall(furnisher.style().window_wall);
}

/// A chair in the middle of the room with a cabinet standing free beside it, behind which it
/// disappears.
void ArrangeOcclusion(Furnisher& furnisher) {
  const double side = furnisher.Draw(-std::numbers::pi, std::numbers::pi);
  const Vector2d out(std::cos(side), std::sin(side));
  furnisher.Place("chair_slat",
                  Upright(0, 0, 0, furnisher.Draw(-std::numbers::pi, std::numbers::pi)));
  furnisher.room().main_instance = 1;
  for (FurnitureModel& model : furnisher.room().catalogue)
    if (model.name == "cabinet_doors") model.back = false;  // This one stands at no wall.
  furnisher.Place("cabinet_doors", Upright(0.62 * out.x(), 0.62 * out.y(), 0, side));
  furnisher.room().walk.start_angle_rad = side - 1.55;
  furnisher.room().walk.radius_m = 1.8;
}

void ScatterClutter(Furnisher& furnisher) {
  const int wanted = furnisher.options().scene == SyntheticScene::kClutter ? 12 : 2;
  const auto draw = [&](double low, double high) {
    return static_cast<float>(furnisher.Draw(low, high));
  };
  for (int i = 0, placed = 0; i < 60 && placed < wanted; ++i) {
    const int wall = static_cast<int>(furnisher.random().Index(4));
    const double half = WallLength(furnisher.room(), wall) / 2;
    const PaintedBody body =
        i % 4 == 3
            ? Basket(furnisher.random())
            : CardboardBox({draw(0.2, 0.42), draw(0.25, 0.5), draw(0.15, 0.4)}, furnisher.random());
    const double azimuth = furnisher.Draw(-0.6, 0.6), y = furnisher.Draw(-half + 0.4, half - 0.4),
                 x = furnisher.Draw(0.28, 0.5);
    const Isometry3d at = RoomFromWall(furnisher.room(), wall) * Upright(x, y, 0, azimuth);
    placed += furnisher.DecorateFloor(body, at);
  }
}

void PlanWalk(Furnisher& furnisher) {
  WalkPlan& walk = furnisher.room().walk;
  const SyntheticOptions& options = furnisher.options();
  // The walk of `rates` is the same for any rate and number of frames.
  const double seconds =
      options.scene == SyntheticScene::kRates ? kRatesSeconds : options.frames / options.rate_hz;
  walk.eye_height_m = furnisher.Draw(1.38, 1.55);
  walk.focus_height_m = 0.95;
  walk.sweep_rad = (furnisher.Chance(0.5) ? 1 : -1) * 2 * std::numbers::pi;
  switch (options.scene) {
    case SyntheticScene::kOcclusion:
      walk.sweep_rad = 2 * std::numbers::pi;
      walk.focus_height_m = 0.65;
      break;
    case SyntheticScene::kTruncation:
      walk.gaze_offset_rad = 0.62 * (furnisher.Chance(0.5) ? 1 : -1);
      break;
    case SyntheticScene::kBlur:
      for (double from_s = 1.5; from_s * options.rate_hz < options.frames; from_s += 2.5) {
        const auto frame = [&](double t_s) {
          return static_cast<int>(std::lround(t_s * options.rate_hz));
        };
        walk.shaken_frames.emplace_back(frame(from_s), frame(from_s + 1));
      }
      break;
    default:
      break;
  }
  const double sweep = 3.5 * walk.radius_m;
  walk.speed_m_s = std::clamp(sweep / seconds, 0.35, 0.6);
}

void FurnishLivingRoom(Furnisher& furnisher) {
  Room& room = furnisher.room();
  RoomStyle& style = furnisher.style();
  if (furnisher.options().scene == SyntheticScene::kTwins)
    room.catalogue = TwinCatalogue(furnisher.palette());
  room.size = {furnisher.Draw(6.6, 7.2), furnisher.Draw(5.9, 6.4), 2.6};
  if (furnisher.options().scene == SyntheticScene::kLowContrast) {
    // Chairs and tables have the colour of the floor, the seats that of the walls.
    style.floor.color = furnisher.palette().wood.color;
    style.floor.accent = furnisher.palette().wood.accent;
    style.walls.color = furnisher.palette().fabric.color;
    style.accent_wall = style.walls;
    style.accent_wall.color = furnisher.palette().lacquer.color;
  }
  if (furnisher.demo()) {
    style.floor.pattern = Pattern::kPlanks;
    style.floor.color = ColorFromHex(0xa98a68);
    style.floor.accent = ColorFromHex(0x7d6146);
    style.walls.color = ColorFromHex(0xeee8dc);
    style.sun_strength = 7.5f;
    style.sun_height_deg = 27;
    style.sun_side_deg = 6;
    style.sky_strength = 7.5f;
    style.lamp_strength = 2.0f;
    style.window_wall = 1;
    style.accent_wall_index = 2;
    style.accent_wall.pattern = Pattern::kPlaster;
    style.accent_wall.color = ColorFromHex(0x9fb0a3);
  }
  BuildShell(style, room);
  room.walk.start_angle_rad = furnisher.Draw(-std::numbers::pi, std::numbers::pi);
  if (furnisher.options().scene == SyntheticScene::kOcclusion) {
    ArrangeOcclusion(furnisher);
  } else {
    furnisher.ArrangeDining({furnisher.Draw(-0.3, 0.3), furnisher.Draw(-0.25, 0.25)});
    room.walk.focus = room.obstacles.front().center;
  }
  FurnishWalls(furnisher);
  ScatterClutter(furnisher);
  PlanWalk(furnisher);
}

void Furnish(Furnisher& furnisher) {
  switch (furnisher.options().scene) {
    case SyntheticScene::kWall:
      return FurnishDividedRoom(furnisher);
    case SyntheticScene::kRows:
      return FurnishSeminarRoom(furnisher);
    case SyntheticScene::kRevisit:
      return FurnishRoundCorridor(furnisher);
    case SyntheticScene::kOffice:
      return FurnishOffice(furnisher);
    case SyntheticScene::kPlatform:
      return FurnishPlatformRoom(furnisher);
    case SyntheticScene::kStreet:
    case SyntheticScene::kPavement:
      return FurnishStreet(furnisher);
    default:
      return FurnishLivingRoom(furnisher);
  }
}

}  // namespace

Eigen::Vector3f SkyLight::Radiance(const Eigen::Vector3f& direction) const {
  if (direction.z() <= 0) return ground;
  const float height = std::pow(direction.z(), 0.55f);
  const Eigen::Vector3f clear = horizon + (zenith - horizon) * height;
  // Clouds lie in a plane; towards the horizon they run together.
  const float reach = 1 / (direction.z() + 0.12f);
  const float cloud =
      FractalNoise({1.3f * reach * direction.x(), 1.3f * reach * direction.y(), 0.5f}, 4, seed);
  const float share = std::clamp(3.2f * (cloud - 0.52f), 0.0f, 0.85f);
  return clear + (1.05f * horizon + Eigen::Vector3f::Constant(0.12f) - clear) * share;
}

std::span<const RoomPart> StillParts(const Room& room) {
  const auto moving = std::find_if(room.parts.begin(), room.parts.end(), [](const RoomPart& part) {
    return !part.velocity_m_s.isZero();
  });
  PLB_CHECK(std::all_of(moving, room.parts.end(), [](const RoomPart& part) {
    return !part.velocity_m_s.isZero();
  })) << "what moves comes last";
  return {room.parts.begin(), moving};
}

Result<Room> FurnishRoom(const SyntheticOptions& options) {
  constexpr int kAttempts = 200;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Furnisher furnisher(options, attempt);
    Furnish(furnisher);
    Room& room = furnisher.room();
    if (!furnisher.failed() && Walk::Plan(room, options.seed, options.rate_hz).ok())
      return std::move(room);
  }
  return Error{ErrorCode::kDegenerate,
               "no room with a free walk round its middle was found for seed " +
                   std::to_string(options.seed)};
}

}  // namespace plumbline
