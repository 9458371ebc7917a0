// SPDX-License-Identifier: Apache-2.0
#include "engine/models/axis_guess.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/surface_sampling.h"
#include "engine/models/category_table.h"

namespace plumbline {
namespace {

constexpr int kSamples = 4000;
constexpr std::uint64_t kSeed = 1;

std::string Percent(double share) { return std::to_string(std::lround(100 * share)) + " %"; }

/// The samples that all judgements are made on, with the surface they come from.
struct Shape {
  Eigen::AlignedBox3d bounds;
  Eigen::Vector3d centroid{0, 0, 0};
  std::vector<Eigen::Vector3d> points;  ///< On the surface, uniform by area.
  std::vector<Eigen::Vector3d> vertices;
  std::array<double, 3>
      flat_share{};  ///< Of the area, within 8 degrees of perpendicular to an axis.
  std::array<double, 3>
      asymmetry{};  ///< Mean distance of the mirror image, in diagonals, per axis.
};

Result<Shape> Measure(const TriangleMesh& mesh) {
  const Result<SurfaceSamples> samples = SampleSurface(mesh, kSamples, kSeed);
  if (!samples.ok()) return samples.error();
  const auto surface = ClosestTriangleSearch::Build(mesh);
  if (!surface.ok()) return surface.error();
  Shape shape;
  shape.points = samples->points;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (const int corner : triangle)
      shape.vertices.push_back(mesh.vertices[static_cast<std::size_t>(corner)].cast<double>());
  }
  for (const Eigen::Vector3d& vertex : shape.vertices) shape.bounds.extend(vertex);
  for (const Eigen::Vector3d& point : shape.points) shape.centroid += point / kSamples;
  for (const int triangle : samples->triangles) {
    const Eigen::Vector3d normal = (*surface)->Normal(triangle).cwiseAbs();
    for (int axis = 0; axis < 3; ++axis) {
      if (normal[axis] > 0.99) shape.flat_share[static_cast<std::size_t>(axis)] += 1.0 / kSamples;
    }
  }
  std::vector<Eigen::Vector3d> mirrored(shape.points.size());
  std::vector<ClosestPoint> closest(shape.points.size());
  for (int axis = 0; axis < 3; ++axis) {
    for (std::size_t i = 0; i < mirrored.size(); ++i) {
      mirrored[i] = shape.points[i];
      mirrored[i][axis] = 2 * shape.bounds.center()[axis] - mirrored[i][axis];
    }
    (*surface)->Find(mirrored, closest);
    double sum = 0;
    for (const ClosestPoint& point : closest) sum += point.distance_m;
    shape.asymmetry[static_cast<std::size_t>(axis)] =
        sum / kSamples / shape.bounds.diagonal().norm();
  }
  return shape;
}

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Counter-clockwise convex hull (Andrew's monotone chain).
std::vector<Eigen::Vector2d> ConvexHull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const auto& a, const auto& b) {
    return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
  });
  std::vector<Eigen::Vector2d> hull;
  for (int pass = 0; pass < 2; ++pass) {
    const std::size_t start = hull.size();
    for (const Eigen::Vector2d& point : points) {
      while (hull.size() >= start + 2 &&
             Cross(hull.back() - hull[hull.size() - 2], point - hull[hull.size() - 2]) <= 0) {
        hull.pop_back();
      }
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

/// How an object stands when `axis` points up.
struct Stand {
  double tipping_rad = 0;  ///< The tilt that it survives.
  /// Distance of its centre from the middle of what it stands on, in radii of that.
  double imbalance = 1;
  int feet = 0;  ///< Separate pieces that touch the plane.
};

/// More pieces are the noise of a scan.
bool HasFeet(const Stand& stand) { return stand.feet >= 3 && stand.feet <= 8; }

/// Pieces of a set of points that are further apart than `gap`: connected cells of a grid.
int CountPieces(const std::vector<Eigen::Vector2d>& points, double gap) {
  std::set<std::pair<int, int>> cells;
  for (const Eigen::Vector2d& point : points) {
    cells.emplace(static_cast<int>(std::floor(point.x() / gap)),
                  static_cast<int>(std::floor(point.y() / gap)));
  }
  int pieces = 0;
  std::vector<std::pair<int, int>> open;
  while (!cells.empty()) {
    ++pieces;
    open.push_back(*cells.begin());
    cells.erase(cells.begin());
    while (!open.empty()) {
      const auto [x, y] = open.back();
      open.pop_back();
      for (int i = 0; i < 9; ++i) {
        const std::pair<int, int> neighbour(x + i % 3 - 1, y + i / 3 - 1);
        if (cells.erase(neighbour) > 0) open.push_back(neighbour);
      }
    }
  }
  return pieces;
}

Stand StandOn(const Shape& shape, const SignedAxis& up) {
  const int u = (up.axis + 1) % 3, v = (up.axis + 2) % 3;
  const double height = shape.bounds.sizes()[up.axis];
  const auto above = [&](const Eigen::Vector3d& point) {
    return up.sign > 0 ? point[up.axis] - shape.bounds.min()[up.axis]
                       : shape.bounds.max()[up.axis] - point[up.axis];
  };
  std::vector<Eigen::Vector2d> contacts;
  for (const auto* points : {&shape.points, &shape.vertices}) {
    for (const Eigen::Vector3d& point : *points) {
      if (above(point) <= 0.03 * height) contacts.emplace_back(point[u], point[v]);
    }
  }
  const std::vector<Eigen::Vector2d> hull = ConvexHull(contacts);
  if (hull.size() < 3) return {};
  const Eigen::Vector2d centre(shape.centroid[u], shape.centroid[v]);
  double margin = std::numeric_limits<double>::max(), doubled_area = 0;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d& a = hull[i];
    const Eigen::Vector2d& b = hull[(i + 1) % hull.size()];
    margin = std::min(margin, Cross((b - a).normalized(), centre - a));
    doubled_area += Cross(a, b);
    middle += (a + b) * Cross(a, b) / 3.0;
  }
  if (!(doubled_area > 0)) return {};
  middle /= doubled_area;
  Stand stand;
  stand.tipping_rad = std::atan2(margin, std::max(above(shape.centroid), 1e-12));
  stand.imbalance = (centre - middle).norm() / std::sqrt(doubled_area / (2 * std::numbers::pi));
  stand.feet = CountPieces(contacts, 0.1 * std::sqrt(0.5 * doubled_area));
  return stand;
}

/// 1 if the extent along the axis is as usual for the category, 0 if not, 1 where nothing is known.
double Proportioned(const Eigen::Vector3d& size, int axis, std::string_view category) {
  const CategoryHabit* usual = FindCategoryHabit(category);
  if (usual == nullptr || usual->proportion == Proportion::kEither) return 1.0;
  return usual->proportion == Proportion::kTall
             ? (size[axis] >= 0.99 * size.maxCoeff() ? 1.0 : 0.0)
             : (size[axis] <= 1.01 * size.minCoeff() ? 1.0 : 0.0);
}

/// How often files of a kind have an axis (x, y, z) point up; x is rare everywhere.
double UpHabit(const SignedAxis& up, std::string_view extension) {
  static constexpr std::array<double, 3> kObj = {0.04, 0.56, 0.40}, kOther = {0.04, 0.36, 0.60};
  return (up.sign > 0 ? 0.9 : 0.1) *
         (extension == ".obj" ? kObj : kOther)[static_cast<std::size_t>(up.axis)];
}

}  // namespace

std::string SignedAxis::text() const { return std::string(sign > 0 ? "+" : "-") + "xyz"[axis]; }

std::optional<SignedAxis> ParseSignedAxis(std::string_view text) {
  SignedAxis axis;
  if (!text.empty() && (text[0] == '+' || text[0] == '-')) {
    axis.sign = text[0] == '+' ? 1 : -1;
    text.remove_prefix(1);
  }
  if (text.size() != 1 || text[0] < 'x' || text[0] > 'z') return std::nullopt;
  axis.axis = text[0] - 'x';
  return axis;
}

double MetresPer(LengthUnit unit) {
  static constexpr std::array<double, 3> kMetres = {1.0, 0.01, 0.001};
  return kMetres[static_cast<std::size_t>(unit)];
}

const char* NameOf(LengthUnit unit) {
  static constexpr std::array<const char*, 3> kNames = {"m", "cm", "mm"};
  return kNames[static_cast<std::size_t>(unit)];
}

std::optional<LengthUnit> ParseLengthUnit(std::string_view text) {
  for (const LengthUnit unit :
       {LengthUnit::kMetre, LengthUnit::kCentimetre, LengthUnit::kMillimetre}) {
    if (text == NameOf(unit)) return unit;
  }
  return std::nullopt;
}

Guess<LengthUnit> GuessUnit(const Eigen::Vector3f& size, std::string_view category,
                            std::string_view extension) {
  if (extension == ".glb" || extension == ".gltf")
    return {LengthUnit::kMetre, 1.0, "glTF files are in metres by definition"};
  // Log-normal in the longest side: of the category, else of anything that stands in a room.
  double expected_m = 0.7, spread = 1.1;
  if (const CategoryHabit* usual = FindCategoryHabit(category); usual != nullptr) {
    expected_m = usual->largest_m;
    spread = 0.5;
  }
  const std::array<double, 3> habit = extension == ".stl" ? std::array<double, 3>{0.25, 0.15, 0.6}
                                                          : std::array<double, 3>{0.6, 0.25, 0.15};
  std::array<double, 3> likely{};
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double largest_m =
        static_cast<double>(size.maxCoeff()) * MetresPer(static_cast<LengthUnit>(i));
    const double deviation = std::log(std::max(largest_m, 1e-12) / expected_m) / spread;
    // A floor under the tails: of three absurd sizes none is certain.
    likely[i] = habit[i] * (std::exp(-0.5 * deviation * deviation) + 1e-6);
    sum += likely[i];
  }
  const std::size_t best =
      static_cast<std::size_t>(std::max_element(likely.begin(), likely.end()) - likely.begin());
  Guess<LengthUnit> guess;
  guess.value = static_cast<LengthUnit>(best);
  guess.confidence = likely[best] / sum;
  char text[160];
  std::snprintf(text, sizeof(text), "so its longest side is %.3g m, and %.2g m is usual for %s",
                static_cast<double>(size.maxCoeff()) * MetresPer(guess.value), expected_m,
                spread < 1 ? std::string(category).c_str() : "things in a room");
  guess.reason = text;
  return guess;
}

Result<Guess<SignedAxis>> GuessUp(const TriangleMesh& mesh, std::string_view extension,
                                  std::string_view category, std::optional<int> only_axis) {
  if (!only_axis && (extension == ".glb" || extension == ".gltf"))
    return Guess<SignedAxis>{{1, 1}, 1.0, "glTF files are y up by definition"};
  const Result<Shape> shape = Measure(mesh);
  if (!shape.ok()) return shape.error();
  const double most_asymmetric =
      *std::max_element(shape->asymmetry.begin(), shape->asymmetry.end());
  const double most_flat = *std::max_element(shape->flat_share.begin(), shape->flat_share.end());
  // A cupboard looks alike upside down and on its back: then only the habit of the format speaks.
  const bool plain_box = most_asymmetric < 0.01;
  Guess<SignedAxis> guess;
  Stand best;
  double sum = 0, highest = 0;
  for (const int axis : {0, 1, 2}) {
    if (only_axis && axis != *only_axis) continue;
    const auto i = static_cast<std::size_t>(axis);
    const double asymmetry = plain_box ? 1.0 : shape->asymmetry[i] / most_asymmetric;
    const double flatness = plain_box || !(most_flat > 0) ? 1.0 : shape->flat_share[i] / most_flat;
    for (const int sign : {1, -1}) {
      const SignedAxis up{axis, sign};
      const Stand stand = StandOn(*shape, up);
      const double stability =
          std::clamp(stand.tipping_rad / 0.26, 0.0, 1.0);  // 15 degrees are enough
      const double balance = std::max(0.0, 1.0 - stand.imbalance);
      const double legs = HasFeet(stand) ? 1.0 : 0.0;
      const double likely =
          UpHabit(up, extension) *
          std::exp(3.0 * stability + 3.0 * balance + 3.0 * asymmetry + 2.5 * flatness + 2.0 * legs +
                   3.0 * Proportioned(shape->bounds.sizes(), axis, category));
      sum += likely;
      if (likely <= highest) continue;
      highest = likely;
      guess.value = up;
      best = stand;
    }
  }
  guess.confidence = highest / sum;
  guess.reason = std::string("so it stands on ") +
                 (HasFeet(best) ? std::to_string(best.feet) + " feet" : "its base") + " up to " +
                 std::to_string(std::lround(best.tipping_rad * 180 / std::numbers::pi)) +
                 " degrees of tilt, its centre " + Percent(best.imbalance) +
                 " of the base's radius off the middle";
  return guess;
}

Result<Guess<SignedAxis>> GuessFront(const TriangleMesh& mesh, const SignedAxis& up) {
  const Result<Shape> shape = Measure(mesh);
  if (!shape.ok()) return shape.error();
  const int u = (up.axis + 1) % 3, v = (up.axis + 2) % 3;
  const double asymmetry_u = shape->asymmetry[static_cast<std::size_t>(u)];
  const double asymmetry_v = shape->asymmetry[static_cast<std::size_t>(v)];
  Guess<SignedAxis> guess;
  if (std::max(asymmetry_u, asymmetry_v) < 0.004) {
    guess.value = {shape->bounds.sizes()[u] >= shape->bounds.sizes()[v] ? u : v, 1};
    guess.confidence = 0.5;
    guess.reason = "along its longer side; both sides look alike, so there is no front to find";
    return guess;
  }
  const int axis = asymmetry_u > asymmetry_v ? u : v;
  const double clearness =
      std::max(asymmetry_u, asymmetry_v) / std::max(asymmetry_u + asymmetry_v, 1e-12);
  // The highest quarter: a back rest or a head board stands at the back.
  double offset = 0;
  int tall = 0;
  const double middle = shape->bounds.center()[up.axis],
               half_height = 0.5 * shape->bounds.sizes()[up.axis];
  for (const Eigen::Vector3d& point : shape->points) {
    if (up.sign * (point[up.axis] - middle) < 0.5 * half_height) continue;
    offset += point[axis] - shape->bounds.center()[axis];
    ++tall;
  }
  offset = tall > 0 ? offset / tall / (0.5 * shape->bounds.sizes()[axis]) : 0;
  guess.value = {axis, offset > 0 ? -1 : 1};
  guess.confidence = clearness / (1.0 + std::exp(-8.0 * std::abs(offset)));
  guess.reason = "its highest quarter lies " + Percent(std::abs(offset)) +
                 " of half the depth to the other side, and left and right are " +
                 (clearness > 0.75 ? "alike" : "somewhat alike");
  return guess;
}

}  // namespace plumbline
