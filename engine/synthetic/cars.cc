// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/cars.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/check.h"
#include "engine/geometry/angles.h"
#include "engine/synthetic/furniture_parts.h"

namespace plumbline {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;

constexpr float kStationM = 0.09f;   ///< Between cross-sections, at most.
constexpr float kTumblehome = 0.3f;  ///< How far the windows lean in, per height.
constexpr float kPillarM = 0.09f;    ///< Width of the posts between windows.
constexpr float kCreaseCosine = 0.82f;
/// Shares by which the measures of a kind vary (standard deviation): length, width, height and
/// wheelbase as they do between the makes of one class.
constexpr float kVaried = 0.04f, kVariedWidth = 0.02f;

constexpr std::array kKinds = {
    CarKind{"car_small",
            "small hatchback",
            {.length = 3.75f,
             .width = 1.68f,
             .height = 1.50f,
             .wheelbase = 2.42f,
             .front_overhang = 0.74f,
             .wheel_radius = 0.29f,
             .cowl_height = 1.0f,
             .cowl = 0.92f,
             .windscreen = 0.72f,
             .roof_end = 3.22f,
             .rear_window = 0.36f,
             .deck_height = 0.96f,
             .belt_height = 0.96f},
            0.2},
    CarKind{"car_hatchback",
            "compact car",
            {.length = 4.26f,
             .width = 1.79f,
             .height = 1.46f,
             .wheelbase = 2.63f,
             .front_overhang = 0.86f,
             .cowl_height = 0.98f,
             .cowl = 1.12f,
             .windscreen = 0.82f,
             .roof_end = 3.55f,
             .roof_drop = 0.06f,
             .rear_window = 0.52f,
             .deck_height = 0.98f,
             .belt_height = 0.94f},
            0.25},
    CarKind{"car_sedan",
            "saloon with a boot",
            {.length = 4.68f,
             .width = 1.82f,
             .height = 1.44f,
             .wheelbase = 2.80f,
             .front_overhang = 0.84f,
             .wheel_radius = 0.32f,
             .cowl_height = 0.97f,
             .cowl = 1.25f,
             .windscreen = 0.85f,
             .roof_end = 3.25f,
             .roof_drop = 0.07f,
             .rear_window = 0.72f,
             .deck_height = 1.02f,
             .belt_height = 0.94f},
            0.17},
    CarKind{"car_estate",
            "estate car",
            {.length = 4.66f,
             .width = 1.82f,
             .height = 1.49f,
             .wheelbase = 2.74f,
             .front_overhang = 0.88f,
             .wheel_radius = 0.32f,
             .cowl_height = 0.98f,
             .cowl = 1.22f,
             .windscreen = 0.80f,
             .roof_end = 4.22f,
             .roof_drop = 0.08f,
             .rear_window = 0.36f,
             .deck_height = 1.0f,
             .belt_height = 0.95f},
            0.15},
    CarKind{"car_suv",
            "sport utility vehicle",
            {.length = 4.48f,
             .width = 1.86f,
             .height = 1.68f,
             .wheelbase = 2.66f,
             .front_overhang = 0.88f,
             .wheel_radius = 0.36f,
             .clearance = 0.26f,
             .nose_height = 0.88f,
             .cowl_height = 1.14f,
             .cowl = 1.15f,
             .windscreen = 0.68f,
             .roof_end = 3.95f,
             .roof_drop = 0.06f,
             .rear_window = 0.38f,
             .deck_height = 1.13f,
             .belt_height = 1.10f},
            0.13},
    CarKind{"car_van",
            "van with one box and a short bonnet",
            {.length = 4.85f,
             .width = 1.92f,
             .height = 1.92f,
             .wheelbase = 2.95f,
             .front_overhang = 0.92f,
             .wheel_radius = 0.33f,
             .nose_height = 0.92f,
             .cowl_height = 1.2f,
             .cowl = 0.68f,
             .windscreen = 0.66f,
             .roof_end = 4.66f,
             .roof_drop = 0.03f,
             .rear_window = 0.12f,
             .deck_height = 1.1f,
             .belt_height = 1.14f},
            0.07},
    CarKind{"car_pickup",
            "pick-up with a double cabin",
            {.length = 5.25f,
             .width = 1.86f,
             .height = 1.78f,
             .wheelbase = 3.12f,
             .front_overhang = 0.92f,
             .wheel_radius = 0.38f,
             .clearance = 0.30f,
             .nose_height = 0.98f,
             .cowl_height = 1.16f,
             .cowl = 1.3f,
             .windscreen = 0.62f,
             .roof_end = 3.32f,
             .roof_drop = 0.03f,
             .rear_window = 0.2f,
             .deck_height = 1.14f,
             .belt_height = 1.13f},
            0.03},
};

/// The upper outline of a car from the side: (distance from the front, height), front to rear.
std::vector<Vector2f> Outline(const CarShape& s) {
  const float tail = s.length - 0.07f;
  const float window_end = std::min(s.roof_end + s.rear_window, tail);
  std::vector<Vector2f> points = {{0, s.nose_height - 0.12f},
                                  {0.10f, s.nose_height},
                                  {s.cowl, s.cowl_height},
                                  {s.cowl + s.windscreen, s.height - 0.03f}};
  const float front = points.back().x();
  PLB_CHECK(front < s.roof_end) << "the roof of a car ends before it begins";
  points.emplace_back(front + 0.35f * (s.roof_end - front), s.height);
  points.emplace_back(s.roof_end, s.height - s.roof_drop);
  points.emplace_back(window_end, s.deck_height);
  if (window_end < tail - 0.05f) points.emplace_back(tail, s.deck_height - 0.03f);
  points.emplace_back(s.length, s.deck_height - 0.22f);
  return points;
}

float HeightAt(const std::vector<Vector2f>& outline, float x) {
  if (x < outline.front().x() || x > outline.back().x()) return 0;
  for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
    const Vector2f &a = outline[i], &b = outline[i + 1];
    if (x > b.x()) continue;
    return b.x() - a.x() < 1e-6f ? b.y() : a.y() + (b.y() - a.y()) * (x - a.x()) / (b.x() - a.x());
  }
  return outline.back().y();
}

/// Where cross-sections stand: at the corners of the outline, at the posts, and in between.
std::vector<float> Stations(const CarShape& s, const std::vector<float>& posts) {
  std::vector<float> corners;
  for (const Vector2f& point : Outline(s)) corners.push_back(point.x());
  for (const float post : posts) {
    corners.push_back(post - kPillarM / 2);
    corners.push_back(post + kPillarM / 2);
  }
  std::sort(corners.begin(), corners.end());
  std::vector<float> stations = {corners.front()};
  for (const float corner : corners) {
    const float from = stations.back();
    if (corner - from < 0.01f) continue;
    const int pieces = static_cast<int>(std::ceil((corner - from) / kStationM));
    for (int i = 1; i <= pieces; ++i)
      stations.push_back(from +
                         (corner - from) * static_cast<float>(i) / static_cast<float>(pieces));
  }
  return stations;
}

/// How much narrower the body is near its ends.
float PlanTaper(const CarShape& s, float x) {
  const float front = std::max(0.0f, 1 - x / 0.55f),
              rear = std::max(0.0f, 1 - (s.length - x) / 0.4f);
  return 1 - 0.13f * front * front - 0.08f * rear * rear;
}

constexpr int kHalfSection = 8;  ///< Points of a section from the middle below to the middle above.
constexpr int kGlassBand = 4;    ///< Between these points and the next windows lie.

/// Half a cross-section (y >= 0) at a distance from the front.
std::array<Vector2f, kHalfSection> Section(const CarShape& s, const std::vector<Vector2f>& outline,
                                           float x) {
  const float top = HeightAt(outline, x);
  const float half = 0.5f * s.width * PlanTaper(s, x);
  // The underside rises towards both ends.
  const float end = std::min(x, s.length - x);
  const float bottom = s.clearance + 0.12f * std::max(0.0f, 1 - end / 0.3f);
  const float belt = std::min(s.belt_height, top - 0.05f);
  const float cabin = top - belt;
  const float roof = half * 0.975f - kTumblehome * std::max(0.0f, cabin - 0.05f);
  return {{{0, bottom},
           {0.8f * half, bottom},
           {0.985f * half, bottom + 0.09f},
           {half, 0.5f * (bottom + belt)},
           {0.975f * half, belt},
           {roof, top - std::min(0.05f, 0.3f * cabin)},
           {0.82f * roof, top - std::min(0.014f, 0.1f * cabin)},
           {0, top}}};
}

/// Quads between closed sections and flat ends, with normals shared where faces meet gently.
class Loft {
 public:
  explicit Loft(std::vector<std::vector<Vector3f>> sections) : sections_(std::move(sections)) {}

  /// @param paint_of  Of the face behind station i, beside point j.
  template <typename PaintOf>
  void AddTo(PaintedMesh& mesh, PaintOf&& paint_of) const {
    const int rows = static_cast<int>(sections_.size());
    const int columns = static_cast<int>(sections_.front().size());
    for (int i = 0; i + 1 < rows; ++i) {
      for (int j = 0; j < columns; ++j) AddFace(mesh, paint_of(i, j), i, j);
    }
    AddEnd(mesh, paint_of(0, 0), sections_.front(), Vector3f::UnitX());
    AddEnd(mesh, paint_of(rows - 2, 0), sections_.back(), -Vector3f::UnitX());
  }

 private:
  const Vector3f& At(int i, int j) const {
    const auto& section = sections_[static_cast<std::size_t>(i)];
    const int n = static_cast<int>(section.size());
    return section[static_cast<std::size_t>((j % n + n) % n)];
  }
  /// Unit normal of the face behind station i, beside point j; zero outside the body.
  Vector3f FaceNormal(int i, int j) const {
    if (i < 0 || i + 1 >= static_cast<int>(sections_.size())) return Vector3f::Zero();
    const Vector3f across = (At(i, j + 1) - At(i, j)) + (At(i + 1, j + 1) - At(i + 1, j));
    const Vector3f along = (At(i + 1, j) - At(i, j)) + (At(i + 1, j + 1) - At(i, j + 1));
    const Vector3f normal = along.cross(across);
    return normal.norm() < 1e-9f ? Vector3f::Zero() : Vector3f(normal.normalized());
  }
  /// Of a corner of a face: with those neighbours that go on smoothly.
  Vector3f CornerNormal(int i, int j, int corner_i, int corner_j) const {
    const Vector3f own = FaceNormal(i, j);
    Vector3f sum = Vector3f::Zero();
    for (int di = -1; di <= 0; ++di) {
      for (int dj = -1; dj <= 0; ++dj) {
        const Vector3f other = FaceNormal(corner_i + di, corner_j + dj);
        if (other.dot(own) > kCreaseCosine) sum += other;
      }
    }
    return sum.norm() > 0 ? Vector3f(sum.normalized()) : own;
  }
  void AddFace(PaintedMesh& mesh, int paint, int i, int j) const {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const auto& [di, dj] :
         {std::pair(0, 0), std::pair(1, 0), std::pair(1, 1), std::pair(0, 1)}) {
      const Vector3f& point = At(i + di, j + dj);
      mesh.vertices.push_back(point);
      mesh.normals.push_back(CornerNormal(i, j, i + di, j + dj));
      mesh.texture.push_back(point);
    }
    AddTriangle(mesh, paint, {first, first + 1, first + 2});
    AddTriangle(mesh, paint, {first, first + 2, first + 3});
  }
  static void AddTriangle(PaintedMesh& mesh, int paint, const Eigen::Vector3i& corners) {
    const auto at = [&](int k) { return mesh.vertices[static_cast<std::size_t>(corners[k])]; };
    if ((at(1) - at(0)).cross(at(2) - at(0)).norm() < 1e-8f) return;
    mesh.triangles.push_back(corners);
    mesh.paints.push_back(paint);
  }
  static void AddEnd(PaintedMesh& mesh, int paint, const std::vector<Vector3f>& section,
                     const Vector3f& normal) {
    const int first = static_cast<int>(mesh.vertices.size());
    const int n = static_cast<int>(section.size());
    for (const Vector3f& point : section) {
      mesh.vertices.push_back(point);
      mesh.normals.push_back(normal);
      mesh.texture.push_back(point);
    }
    for (int j = 1; j + 1 < n; ++j) {
      const bool front = normal.x() > 0;
      AddTriangle(mesh, paint, {first, first + (front ? j : j + 1), first + (front ? j + 1 : j)});
    }
  }

  std::vector<std::vector<Vector3f>> sections_;
};

struct CarPaints {
  int body, glass, tyre, rim, trim, head_lamp, tail_lamp, plate;
};

void AddWheel(PaintedMesh& mesh, const CarPaints& paints, const Vector3f& outer_middle,
              float radius, float side) {
  const Eigen::Matrix3f turn =
      Eigen::AngleAxisf(-side * kPiF / 2, Vector3f::UnitX()).toRotationMatrix();
  const auto lathe = [&](int paint, const Vector3f& middle, const std::vector<Vector2f>& profile) {
    const std::size_t first = mesh.vertices.size();
    AddLathe(mesh, paint, Vector3f::Zero(), profile, 20);
    Deform(mesh, first, [&](const Vector3f& p) { return Vector3f(middle + turn * p); });
  };
  const float rim = 0.66f * radius;
  // The arch is a dark disc in the side of the body, clear of the road.
  lathe(paints.trim, outer_middle + 0.14f * radius * Vector3f::UnitZ(),
        {{0, -0.12f}, {1.11f * radius, -0.12f}, {1.11f * radius, -0.008f}, {0, -0.008f}});
  lathe(paints.tyre, outer_middle,
        {{0, -0.2f}, {radius, -0.2f}, {radius, -0.01f}, {0.94f * radius, 0}, {0, 0}});
  lathe(paints.rim, outer_middle,
        {{0, -0.02f}, {rim, -0.02f}, {rim, 0.004f}, {0.8f * rim, 0.008f}, {0, 0.008f}});
}

void AddLampsAndPlates(PaintedMesh& mesh, const CarPaints& paints, const CarShape& s) {
  const std::vector<Vector2f> outline = Outline(s);
  const float front = s.length / 2, half = 0.5f * s.width;
  const float lamp_z = s.nose_height - 0.09f;
  const float tail_z = s.deck_height - 0.16f - 0.05f;
  for (const float side : {-1.0f, 1.0f}) {
    AddBlock(mesh, paints.head_lamp, {front - 0.12f, side * 0.68f * half, lamp_z},
             {0.24f, 0.36f * half, 0.12f}, 0.02f);
    AddBlock(mesh, paints.tail_lamp, {-front + 0.08f, side * 0.74f * half, tail_z},
             {0.18f, 0.24f * half, 0.16f}, 0.02f);
    const float mirror_x = front - s.cowl - 0.35f * s.windscreen;
    AddBlock(mesh, paints.body, {mirror_x, side * (half + 0.07f), s.belt_height + 0.07f},
             {0.1f, 0.2f, 0.13f}, 0.03f);
  }
  AddBlock(mesh, paints.trim, {front - 0.02f, 0, 0.36f}, {0.07f, 1.1f * half, 0.14f}, 0.02f);
  AddBlock(mesh, paints.plate, {front + 0.02f, 0, 0.44f}, {0.02f, 0.52f, 0.11f}, 0.004f);
  AddBlock(mesh, paints.trim, {-front + 0.02f, 0, s.clearance + 0.17f}, {0.07f, 1.5f * half, 0.12f},
           0.02f);
  AddBlock(mesh, paints.plate, {-front - 0.015f, 0, std::min(0.62f, s.deck_height - 0.35f)},
           {0.03f, 0.52f, 0.11f}, 0.004f);
}

}  // namespace

std::span<const CarKind> CarKinds() { return kKinds; }

CarShape DrawCar(Random& random) {
  double pick = random.Uniform();
  std::size_t kind = 0;
  while (kind + 1 < kKinds.size() && pick >= kKinds[kind].share) pick -= kKinds[kind++].share;
  CarShape s = kKinds[kind].shape;
  const auto factor = [&](float share) {
    return 1 + share * static_cast<float>(std::clamp(random.Gaussian(), -2.0, 2.0));
  };
  // What lies along the car grows with it, and moves a little besides.
  const float along = factor(kVaried), up = factor(0.75f * kVaried);
  s.length *= along;
  s.width *= factor(kVariedWidth);
  s.height *= up;
  s.wheelbase *= along * factor(0.015f);
  s.front_overhang *= along;
  s.wheel_radius *= factor(kVaried);
  s.nose_height *= up * factor(0.03f);
  s.cowl_height *= up;
  s.cowl *= along * factor(0.08f);
  s.windscreen *= along * factor(0.08f);
  s.roof_end *= along * factor(0.02f);
  s.roof_end = std::min(s.roof_end, s.length - 0.16f);
  s.rear_window *= along * factor(0.12f);
  s.deck_height *= up * factor(0.02f);
  s.belt_height = std::min(s.belt_height * up * factor(0.015f), s.height - 0.38f);
  return s;
}

double OutlineDifference(const CarShape& a, const CarShape& b) {
  constexpr float kStep_m = 0.05f;
  const std::vector<Vector2f> outline_a = Outline(a), outline_b = Outline(b);
  const float longer = std::max(a.length, b.length);
  const int steps = static_cast<int>(std::ceil(longer / kStep_m));
  double sum = 0;
  for (int i = 0; i <= steps; ++i) {
    const float from_middle = longer * (static_cast<float>(i) / static_cast<float>(steps) - 0.5f);
    const float off = HeightAt(outline_a, from_middle + a.length / 2) -
                      HeightAt(outline_b, from_middle + b.length / 2);
    sum += off * off;
  }
  const double wider = 0.5 * (a.width - b.width);
  return std::sqrt(sum / (steps + 1)) + std::abs(wider);
}

std::size_t NearestKind(const CarShape& shape) {
  const auto nearer = [&](const CarKind& a, const CarKind& b) {
    return OutlineDifference(shape, a.shape) < OutlineDifference(shape, b.shape);
  };
  return static_cast<std::size_t>(std::min_element(kKinds.begin(), kKinds.end(), nearer) -
                                  kKinds.begin());
}

PaintedBody CarBody(const CarShape& s, const Material& paint) {
  PaintedBody body;
  CarPaints paints{};
  paints.body = body.Paint(paint);
  paints.glass = body.Paint({.color = ColorFromHex(0x23292c), .gloss = 0.08f, .roughness = 0.01f});
  paints.tyre = body.Paint({.color = ColorFromHex(0x1b1b1c)});
  paints.rim = body.Paint({.color = ColorFromHex(0xa4a7aa), .gloss = 0.1f, .roughness = 0.2f});
  paints.trim = body.Paint({.color = ColorFromHex(0x141516)});
  paints.head_lamp =
      body.Paint({.color = ColorFromHex(0xdfe5e8), .gloss = 0.08f, .roughness = 0.05f});
  paints.tail_lamp =
      body.Paint({.color = ColorFromHex(0x8f1a1a), .gloss = 0.06f, .roughness = 0.05f});
  paints.plate = body.Paint({.color = ColorFromHex(0xe9e9e4)});

  const std::vector<Vector2f> outline = Outline(s);
  const float roof_front = s.cowl + s.windscreen, window_end = s.roof_end + s.rear_window;
  const float middle_post = roof_front + 0.47f * (s.roof_end - roof_front);
  std::vector<float> posts = {middle_post};
  // Behind the rear door, where the roof goes on long enough for another window.
  const float rear_post = s.front_overhang + s.wheelbase - 0.05f;
  if (rear_post > middle_post + 0.5f && rear_post < s.roof_end - 0.1f) posts.push_back(rear_post);
  const std::vector<float> stations = Stations(s, posts);
  std::vector<std::vector<Vector3f>> sections;
  for (const float x : stations) {
    const auto half = Section(s, outline, x);
    std::vector<Vector3f> section;
    // Once round, seen from the front counter-clockwise: up on the left side (+y), down again.
    for (const Vector2f& p : half) section.emplace_back(s.length / 2 - x, p.x(), p.y());
    for (int k = kHalfSection - 2; k > 0; --k)
      section.emplace_back(s.length / 2 - x, -half[static_cast<std::size_t>(k)].x(),
                           half[static_cast<std::size_t>(k)].y());
    sections.push_back(std::move(section));
  }
  const int columns = 2 * kHalfSection - 2;
  const auto paint_of = [&](int i, int j) {
    const float x =
        0.5f * (stations[static_cast<std::size_t>(i)] + stations[static_cast<std::size_t>(i + 1)]);
    const int band = j < columns / 2 ? j : columns - 1 - j;
    const bool on_top = band > kGlassBand;
    if (on_top) {
      const bool screen = x > s.cowl + 0.03f && x < roof_front - 0.04f;
      const bool rear =
          x > s.roof_end + 0.04f && x < std::min(window_end, s.length - 0.07f) - 0.05f;
      return screen || rear ? paints.glass : paints.body;
    }
    if (band != kGlassBand) return band <= 1 ? paints.trim : paints.body;
    const bool near_post = std::any_of(
        posts.begin(), posts.end(), [&](float post) { return std::abs(x - post) < kPillarM / 2; });
    const bool cabin = x > s.cowl + 0.3f * s.windscreen && x < s.roof_end + 0.25f * s.rear_window;
    return cabin && !near_post ? paints.glass : paints.body;
  };
  Loft(std::move(sections)).AddTo(body.mesh, paint_of);

  for (const float along : {s.front_overhang, s.front_overhang + s.wheelbase}) {
    for (const float side : {-1.0f, 1.0f}) {
      const float half = 0.5f * s.width * PlanTaper(s, along);
      AddWheel(body.mesh, paints, {s.length / 2 - along, side * (half + 0.012f), s.wheel_radius},
               s.wheel_radius, side);
    }
  }
  AddLampsAndPlates(body.mesh, paints, s);
  StandOnOrigin(body.mesh);
  return body;
}

FurnitureModel CarModel(const std::string& name, const std::string& note, const CarShape& shape) {
  FurnitureModel model;
  model.name = name;
  model.category = "car";
  model.note = note;
  model.body = CarBody(shape, {.color = ColorFromHex(0x9a9c9e)});
  return model;
}

std::vector<FurnitureModel> GenericCars() {
  std::vector<FurnitureModel> models;
  for (const CarKind& kind : kKinds)
    models.push_back(CarModel(std::string(kind.name), std::string(kind.note), kind.shape));
  return models;
}

Material CarPaint(Random& random) {
  constexpr std::array<std::uint32_t, 12> kColors = {0xe8e8e4, 0xdedfdd, 0xb9bcbe, 0x9a9da0,
                                                     0x6f7276, 0x4a4d51, 0x232427, 0x1d2126,
                                                     0x2c4668, 0x7d2226, 0x3d5a48, 0xb58a4a};
  return {.color = ColorFromHex(kColors[random.Index(kColors.size())]),
          .gloss = 0.035f,
          .roughness = 0.04f};
}

}  // namespace plumbline
