// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/street.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "engine/geometry/angles.h"
#include "engine/synthetic/cars.h"
#include "engine/synthetic/furniture_parts.h"

namespace plumbline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

// Across the street, from its middle [m].
constexpr double kLane = 1.75;     ///< Middle of a lane; traffic keeps to the right.
constexpr double kKerb = 5.7;      ///< The parking lanes lie inside of it.
constexpr double kParked = 4.6;    ///< Middle of what is parked.
constexpr double kPavement = 2.6;  ///< Its width.
constexpr float kKerbHeight = 0.12f;
constexpr double kFronts = kKerb + kPavement + 0.9;  ///< Of the houses, at the least.
// Along it.
constexpr double kBehind = 18, kAhead = 75;  ///< What there is before the start and past the end.
constexpr double kRouteStep = 6;
constexpr double kCarCameraHeight = 1.65;  ///< KITTI's.
constexpr int kShapes = 9;                 ///< Different cars in a street.
constexpr double kGap = 0.3;               ///< Share of the places at the kerb that are empty.
constexpr double kReversed = 0.2;          ///< Of parked cars, against the traffic.

float Between(Random& random, double low, double high) {
  return static_cast<float>(random.Uniform(low, high));
}

/// How the camera goes along the street.
struct Passage {
  double from_m = 0, length_m = 0;  ///< Along x.
  double speed_m_s = 0;
  double seconds = 0;
};

Passage PassageOf(Furnisher& furnisher) {
  const SyntheticOptions& options = furnisher.options();
  Passage passage;
  passage.seconds = options.frames / options.rate_hz;
  passage.speed_m_s =
      options.scene == SyntheticScene::kStreet ? furnisher.Draw(8, 13) : furnisher.Draw(1.3, 1.5);
  passage.length_m = passage.speed_m_s * passage.seconds;
  return passage;
}

void AddSurface(Room& room, const Material& material, const Eigen::AlignedBox2f& area, float height,
                float light_spacing_m) {
  RoomPart part;
  const Eigen::Vector2f size = area.sizes();
  AddQuad(part.body.mesh, part.body.Paint(material), {area.min().x(), area.min().y(), height},
          {size.x(), 0, 0}, {0, size.y(), 0});
  part.light_spacing_m = light_spacing_m;
  room.parts.push_back(std::move(part));
}

/// Road, markings, kerbs and pavements.
void PaveStreet(Furnisher& furnisher, float begin, float end) {
  Room& room = furnisher.room();
  Random& random = furnisher.random();
  const auto kerb = static_cast<float>(kKerb), pavement = static_cast<float>(kPavement);
  const Material asphalt{.pattern = Pattern::kPlaster,
                         .color = ColorFromHex(0x6b6b6a) * Between(random, 0.75, 1.1),
                         .seed = random.Bits() % 1000};
  AddSurface(room, asphalt, {Eigen::Vector2f(begin, -kerb), Eigen::Vector2f(end, kerb)}, 0, 0.14f);
  PaintedBody marks;
  const int white = marks.Paint({.pattern = Pattern::kPlaster, .color = ColorFromHex(0xd8d8d2)});
  const int patch = marks.Paint(
      {.pattern = Pattern::kPlaster, .color = asphalt.color * Between(random, 0.6, 0.8)});
  const int lid = marks.Paint({.pattern = Pattern::kPlaster, .color = ColorFromHex(0x4a4744)});
  for (float x = begin + 1; x + 3 < end; x += 6)
    AddQuad(marks.mesh, white, {x, -0.06f, 0.004f}, {3, 0, 0}, {0, 0.12f, 0});
  for (float x = begin + Between(random, 2, 9); x + 4 < end; x += Between(random, 8, 22)) {
    const Vector3f corner(x, Between(random, -kKerb + 0.3, kKerb - 1.8), 0.002f);
    const float across = Between(random, 0.6, 1.5), along = Between(random, 0.8, 3.5);
    AddQuad(marks.mesh, patch, corner, {along, 0, 0}, {0, across, 0});
    AddLathe(marks.mesh, lid, {x + 4, Between(random, -1, 1) + 1.75f, 0},
             {{0.33f, 0.0f}, {0.32f, 0.006f}, {0, 0.006f}}, 20);
  }
  AddDecor(marks, Eigen::Isometry3d::Identity(), 0.2f, room);
  for (const float side : {-1.0f, 1.0f}) {
    const float inner = side > 0 ? kerb : -kerb - pavement, outer = inner + pavement;
    const Material slabs{.pattern = Pattern::kTiles,
                         .color = ColorFromHex(0xa8a49b),
                         .accent = ColorFromHex(0x7d7a73),
                         .scale = 1.6f,
                         .seed = random.Bits() % 1000};
    AddSurface(room, slabs, {Eigen::Vector2f(begin, inner), Eigen::Vector2f(end, outer)},
               kKerbHeight, 0.16f);
    PaintedBody stone;
    const int grey = stone.Paint({.pattern = Pattern::kPlaster, .color = ColorFromHex(0xb3b0a8)});
    AddBlock(stone.mesh, grey, {(begin + end) / 2, side * (kerb + 0.06f), kKerbHeight / 2 + 0.003f},
             {end - begin, 0.14f, kKerbHeight}, 0.01f, 0);
    AddDecor(stone, Eigen::Isometry3d::Identity(), 0.2f, room);
    // Front gardens.
    const float garden = side > 0 ? outer : inner - 8;
    AddSurface(room,
               {.pattern = Pattern::kLeaf,
                .color = ColorFromHex(0x5c7a3c),
                .accent = ColorFromHex(0x4c6a34),
                .seed = random.Bits() % 1000},
               {Eigen::Vector2f(begin, garden), Eigen::Vector2f(end, garden + 8)},
               kKerbHeight - 0.02f, 0.6f);
  }
}

/// The front and the sides of a block on a wall x = 0: what is seen of a frame or a pane.
void AddPanel(PaintedMesh& mesh, int paint, const Vector3f& center, const Vector3f& size) {
  const Vector3f low = center - size / 2, high = center + size / 2;
  const Vector3f x(size.x(), 0, 0), y(0, size.y(), 0), z(0, 0, size.z());
  AddQuad(mesh, paint, {high.x(), low.y(), low.z()}, y, z);
  AddQuad(mesh, paint, low, x, z);
  AddQuad(mesh, paint, {low.x(), high.y(), low.z()}, z, x);
  AddQuad(mesh, paint, low, y, x);
  AddQuad(mesh, paint, {low.x(), low.y(), high.z()}, x, y);
}

/// A house whose front is the plane x = 0, looking along +x, centred on y = 0.
PaintedBody House(float width, int floors, Random& random) {
  constexpr std::array<std::uint32_t, 8> kWalls = {0xd9cdb8, 0xc9b8a0, 0xb0705a, 0x9a5f4b,
                                                   0xe4dfd3, 0xbfc3bd, 0xc7a680, 0x8f9aa0};
  PaintedBody body;
  Material plaster{.pattern = Pattern::kPlaster,
                   .color = ColorFromHex(kWalls[random.Index(kWalls.size())]),
                   .seed = random.Bits() % 1000};
  if (random.Uniform() < 0.35) {
    plaster.pattern = Pattern::kTiles;
    plaster.scale = 0.5f;
    plaster.accent = plaster.color * 1.25f;
  }
  const int wall = body.Paint(plaster);
  const int frame =
      body.Paint({.color = ColorFromHex(random.Uniform() < 0.7 ? 0xe8e6e0 : 0x4b4f52)});
  const int glass =
      body.Paint({.color = ColorFromHex(0x2a3238), .gloss = 0.07f, .roughness = 0.01f});
  const int door =
      body.Paint({.color = ColorFromHex(random.Uniform() < 0.5 ? 0x5a3a2a : 0x2f4a4a)});
  const int tiles = body.Paint({.pattern = Pattern::kTiles,
                                .color = ColorFromHex(random.Uniform() < 0.6 ? 0x8a4a3a : 0x54565a),
                                .accent = ColorFromHex(0x3f3a38),
                                .scale = 0.9f,
                                .seed = random.Bits() % 1000});
  const float storey = Between(random, 2.7, 3.1), base = 0.5f;
  const float height = base + storey * static_cast<float>(floors), depth = 9;
  AddPanel(body.mesh, wall, {-depth / 2, 0, height / 2}, {depth, width, height});
  const int windows = std::max(2, static_cast<int>(width / 2.6f));
  const float pitch = width / static_cast<float>(windows);
  const float wide = std::min(1.25f, 0.5f * pitch), tall = 0.5f * storey;
  const int entrance = static_cast<int>(random.Index(static_cast<std::uint32_t>(windows)));
  for (int floor = 0; floor < floors; ++floor) {
    for (int i = 0; i < windows; ++i) {
      const float y = -width / 2 + (static_cast<float>(i) + 0.5f) * pitch;
      if (floor == 0 && i == entrance) {
        AddPanel(body.mesh, frame, {0.02f, y, 1.15f}, {0.08f, 1.2f, 2.3f});
        AddPanel(body.mesh, door, {0.05f, y, 1.1f}, {0.06f, 1.0f, 2.15f});
        AddPanel(body.mesh, frame, {0.35f, y, 0.08f}, {0.7f, 1.4f, 0.16f});
        continue;
      }
      const float z = base + storey * (static_cast<float>(floor) + 0.52f);
      AddPanel(body.mesh, frame, {0.01f, y, z}, {0.09f, wide + 0.14f, tall + 0.14f});
      AddPanel(body.mesh, glass, {0.045f, y - 0.26f * wide, z},
               {0.04f, 0.44f * wide, tall - 0.06f});
      AddPanel(body.mesh, glass, {0.045f, y + 0.26f * wide, z},
               {0.04f, 0.44f * wide, tall - 0.06f});
      AddPanel(body.mesh, frame, {0.08f, y, z - tall / 2 - 0.09f}, {0.22f, wide + 0.24f, 0.05f});
    }
  }
  AddPanel(body.mesh, frame, {0.12f, 0, height + 0.05f}, {0.35f, width + 0.1f, 0.14f});
  const float rise = Between(random, 2.2, 3.6), over = 0.25f;
  AddQuad(body.mesh, tiles, {over, -width / 2 - 0.1f, height + 0.1f}, {0, width + 0.2f, 0},
          {-depth / 2 - over, 0, rise});
  AddQuad(body.mesh, tiles, {-depth - over, width / 2 + 0.1f, height + 0.1f}, {0, -width - 0.2f, 0},
          {depth / 2 + over, 0, rise});
  return body;
}

void BuildHouses(Furnisher& furnisher, double begin, double end) {
  for (const double side : {-1.0, 1.0}) {
    double x = begin;
    while (x < end) {
      const auto width = static_cast<float>(furnisher.Draw(7, 15));
      const int floors = 2 + static_cast<int>(furnisher.random().Index(3));
      const double front = kFronts + (furnisher.Chance(0.5) ? 0 : furnisher.Draw(0.5, 4));
      furnisher.Decorate(
          House(width, floors, furnisher.random()),
          Upright(x + width / 2, side * front, kKerbHeight - 0.05, -side * std::numbers::pi / 2),
          0.35f);
      x += width + (furnisher.Chance(0.4) ? furnisher.Draw(2, 6) : 0.0);
    }
  }
}

/// A trunk with a crown of several displaced balls.
PaintedBody Tree(Random& random) {
  PaintedBody body;
  const int bark = body.Paint({.pattern = Pattern::kWood,
                               .color = ColorFromHex(0x6f5d4a),
                               .accent = ColorFromHex(0x4a3d30),
                               .seed = random.Bits() % 1000});
  const Vector3f green = ColorFromHex(random.Uniform() < 0.5 ? 0x55762f : 0x6b7f3a);
  const int leaf = body.Paint({.pattern = Pattern::kWeave,
                               .color = green,
                               .accent = green * 0.45f,
                               .scale = 14,
                               .seed = random.Bits() % 1000});
  const float height = Between(random, 2.4, 3.4), radius = Between(random, 0.1, 0.17);
  AddTube(body.mesh, bark,
          SmoothPath({{0, 0, 0},
                      {Between(random, -0.05, 0.05), Between(random, -0.05, 0.05), height / 2},
                      {0, 0, height + 0.8f}},
                     3),
          {radius}, 10);
  const std::uint32_t seed = random.Bits() % 1000;
  for (int ball = 0; ball < 6; ++ball) {
    const float size = Between(random, 0.8, 1.4);
    const float z = height + Between(random, 0.2, 1.8), y = Between(random, -0.8, 0.8),
                x = Between(random, -0.8, 0.8);
    const Vector3f middle(x, y, z);
    std::vector<Eigen::Vector2f> profile;
    for (int i = 0; i <= 12; ++i) {
      const float angle = kPiF * (static_cast<float>(i) / 12 - 0.5f);
      profile.emplace_back(std::max(0.0f, std::cos(angle)) * size * (i == 0 || i == 12 ? 0 : 1),
                           std::sin(angle) * size);
    }
    const std::size_t first = body.mesh.vertices.size();
    AddLathe(body.mesh, leaf, Vector3f::Zero(), profile, 18);
    Deform(body.mesh, first, [&](const Vector3f& p) {
      const float bumps = FractalNoise((p + middle) * 2.2f, 2, seed) - 0.5f;
      return Vector3f(middle + p * (1 + 0.7f * bumps));
    });
  }
  return body;
}

PaintedBody LampPost() {
  PaintedBody body;
  const int steel =
      body.Paint({.color = ColorFromHex(0x6a7075), .gloss = 0.06f, .roughness = 0.2f});
  AddTube(body.mesh, steel, {{0, 0, 0}, {0, 0, 1.0f}, {0, 0, 5.6f}}, {0.075f, 0.06f, 0.045f}, 12);
  AddTube(body.mesh, steel, {{0, 0, 5.6f}, {0.9f, 0, 5.8f}}, {0.035f}, 8);
  AddBlock(body.mesh, steel, {1.05f, 0, 5.78f}, {0.6f, 0.22f, 0.09f}, 0.03f);
  return body;
}

PaintedBody Bin(Random& random) {
  constexpr std::array<std::uint32_t, 4> kColors = {0x2f4a38, 0x33373a, 0x31517a, 0x8a6a2c};
  PaintedBody body;
  const int plastic =
      body.Paint({.color = ColorFromHex(kColors[random.Index(kColors.size())]), .gloss = 0.04f});
  AddBlock(body.mesh, plastic, {0, 0, 0.5f}, {0.6f, 0.55f, 0.9f}, 0.03f);
  AddBlock(body.mesh, plastic, {0.02f, 0, 0.98f}, {0.7f, 0.6f, 0.1f}, 0.03f);
  return body;
}

/// What stands on the pavements: near the kerb trees and posts, at the houses bins.
void LinePavements(Furnisher& furnisher, double begin, double end) {
  for (const double side : {-1.0, 1.0}) {
    const double row = side * (kKerb + 0.45), turned = -side * std::numbers::pi / 2;
    int number = 0;
    for (double x = begin + furnisher.Draw(2, 8); x < end; x += furnisher.Draw(7, 12), ++number) {
      const bool post = number % 3 == 2;
      const PaintedBody body = post ? LampPost() : Tree(furnisher.random());
      furnisher.Reserve({{x, row}, {0.2, 0.2}, 0});
      furnisher.Decorate(body, Upright(x, row, kKerbHeight, turned), post ? 0.1f : 0.12f);
    }
    for (double x = begin + furnisher.Draw(3, 15); x < end; x += furnisher.Draw(12, 30)) {
      const double azimuth = turned + furnisher.Draw(-0.2, 0.2);
      furnisher.DecorateFloor(Bin(furnisher.random()),
                              Upright(x, side * (kKerb + kPavement - 0.35), kKerbHeight, azimuth),
                              0.1f);
    }
  }
}

/// A kind of car that stands in the street, perhaps several times.
struct StreetShape {
  CarShape shape;
  std::string name;
  std::string nearest;
};

std::vector<StreetShape> DrawShapes(Furnisher& furnisher) {
  std::vector<StreetShape> shapes;
  for (int i = 0; i < kShapes; ++i) {
    StreetShape& shape = shapes.emplace_back();
    shape.shape = DrawCar(furnisher.random());
    shape.name = "car_" + std::string(1, static_cast<char>('a' + i));
    shape.nearest = std::string(CarKinds()[NearestKind(shape.shape)].name);
    furnisher.room().right_catalogue.push_back(
        CarModel(shape.name, "like " + shape.nearest, shape.shape));
  }
  return shapes;
}

void AddCar(Furnisher& furnisher, const StreetShape& shape, const Eigen::Isometry3d& pose,
            const Vector3d& velocity_m_s) {
  Room& room = furnisher.room();
  const PaintedBody body = CarBody(shape.shape, CarPaint(furnisher.random()));
  Eigen::AlignedBox3f bounds;
  for (const Vector3f& vertex : body.mesh.vertices) bounds.extend(vertex);
  RoomInstance instance;
  instance.id = "car_" + std::to_string(room.instances.size() + 1);
  instance.model = shape.nearest;
  instance.right_model = shape.name;
  instance.category = "car";
  instance.size_m = bounds.sizes().cast<double>();
  instance.room_from_object = pose;
  instance.velocity_m_s = velocity_m_s;
  room.instances.push_back(instance);
  AddDecor(body, pose, 0.09f, room);
  room.parts.back().instance = static_cast<int>(room.instances.size());
  room.parts.back().velocity_m_s = velocity_m_s;
}

void ParkCars(Furnisher& furnisher, const std::vector<StreetShape>& shapes, double begin,
              double end) {
  for (const double side : {-1.0, 1.0}) {
    double x = begin + furnisher.Draw(0, 4);
    while (true) {
      const StreetShape& shape =
          shapes[furnisher.random().Index(static_cast<std::uint32_t>(shapes.size()))];
      const double length = shape.shape.length;
      if (x + length > end) break;
      const double azimuth = (side > 0 ? std::numbers::pi : 0.0) +
                             (furnisher.Chance(kReversed) ? std::numbers::pi : 0.0) +
                             furnisher.Draw(-0.04, 0.04);
      const Eigen::Isometry3d pose = Upright(
          x + length / 2, side * (kParked + furnisher.Draw(-0.12, 0.1)), 0, WrapAngle(azimuth));
      if (!furnisher.Chance(kGap)) {
        AddCar(furnisher, shape, pose, Vector3d::Zero());
        furnisher.Reserve(
            FootprintOf(furnisher.room().parts.back().body.mesh, Eigen::Isometry3d::Identity()));
      }
      x += length + furnisher.Draw(0.7, 1.8);
    }
  }
}

/// Some meet the camera, one drives ahead of it (or, of a walker, from behind).
void AddTraffic(Furnisher& furnisher, const std::vector<StreetShape>& shapes,
                const Passage& passage) {
  const auto any_shape = [&]() -> const StreetShape& {
    return shapes[furnisher.random().Index(static_cast<std::uint32_t>(shapes.size()))];
  };
  constexpr int kOncoming = 3;
  for (int i = 0; i < kOncoming; ++i) {
    const double meets_s = passage.seconds * (i + furnisher.Draw(0.25, 0.9)) / kOncoming;
    const double speed = furnisher.Draw(7, 13);
    const double x = passage.from_m + passage.speed_m_s * meets_s + speed * meets_s;
    AddCar(furnisher, any_shape(), Upright(x, kLane, 0, std::numbers::pi), {-speed, 0, 0});
  }
  if (passage.speed_m_s > 5) {
    const double gap = furnisher.Draw(14, 24);
    const double speed = passage.speed_m_s + furnisher.Draw(-0.6, 1.2);
    AddCar(furnisher, any_shape(), Upright(passage.from_m + gap, -kLane, 0, 0), {speed, 0, 0});
    return;
  }
  for (int i = 0; i < 2; ++i) {
    const double passes_s = passage.seconds * (i + furnisher.Draw(0.2, 0.8)) / 2;
    const double speed = furnisher.Draw(7, 12);
    AddCar(furnisher, any_shape(),
           Upright(passage.from_m - (speed - passage.speed_m_s) * passes_s, -kLane, 0, 0),
           {speed, 0, 0});
  }
}

void PlanPassage(Furnisher& furnisher, const Passage& passage) {
  WalkPlan& walk = furnisher.room().walk;
  const bool drives = furnisher.options().scene == SyntheticScene::kStreet;
  const double y = drives ? -kLane : -(kKerb + 1.45);
  walk.once = true;
  walk.speed_m_s = passage.speed_m_s;
  walk.sway = drives ? 0.3 : 1;
  walk.exposure_s = drives ? 0.002 : 0.005;
  // The road is level and 0; a walker stands on the kerb's height.
  walk.eye_height_m = drives ? kCarCameraHeight : furnisher.Draw(1.5, 1.65);
  walk.focus_height_m = drives ? walk.eye_height_m - 0.1 : 1.1;
  furnisher.room().camera_height_m = walk.eye_height_m;
  const double begin = passage.from_m - 2 * kRouteStep;
  const double end = passage.from_m + passage.length_m * 1.1 + 2 * kRouteStep;
  // A walker looks at what is parked along the kerb and across the road.
  const Vector2d gaze = drives ? Vector2d(30, 0) : Vector2d(9, 3.2);
  for (double x = begin; x < end; x += kRouteStep)
    walk.route.push_back({{x, y}, Vector2d(x, y) + gaze});
  walk.start_m = passage.from_m - begin;
}

}  // namespace

void FurnishStreet(Furnisher& furnisher) {
  Room& room = furnisher.room();
  Passage passage = PassageOf(furnisher);
  const double length = kBehind + passage.length_m + kAhead;
  passage.from_m = -length / 2 + kBehind;
  room.size = {length + 40, 2 * (kFronts + 16), 14};
  room.catalogue = GenericCars();
  room.scan_spacing_m = 0.2f;

  SkyLight sky;
  sky.seed = furnisher.random().Bits() % 1000;
  room.sky = sky;
  // Mostly from ahead or behind to one side, so that shadows of cars fall on road and pavement.
  const double height = furnisher.Draw(28, 55) * kRadPerDeg,
               side = furnisher.Draw(0, 2 * std::numbers::pi);
  const Vector3d to_sun(std::cos(height) * std::cos(side), std::cos(height) * std::sin(side),
                        std::sin(height));
  room.sun = SunLight{to_sun.cast<float>(),
                      Between(furnisher.random(), 1.6, 2.6) * Vector3f(1.0f, 0.93f, 0.8f), 0.012f};

  const double begin = -length / 2, end = length / 2;
  PaveStreet(furnisher, static_cast<float>(begin - 15), static_cast<float>(end + 15));
  BuildHouses(furnisher, begin - 15, end + 12);
  LinePavements(furnisher, begin, end);
  const std::vector<StreetShape> shapes = DrawShapes(furnisher);
  ParkCars(furnisher, shapes, begin, end);
  AddTraffic(furnisher, shapes, passage);
  PlanPassage(furnisher, passage);
}

}  // namespace plumbline
