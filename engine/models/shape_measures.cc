// SPDX-License-Identifier: Apache-2.0
#include "engine/models/shape_measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>
#include <utility>

#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/surface_sampling.h"

namespace plumbline {
namespace {

constexpr int kSamples = 4000;
constexpr std::uint64_t kSeed = 1;

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

double AreaOf(const std::vector<Eigen::Vector2d>& polygon) {
  double doubled = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i)
    doubled += Cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return 0.5 * doubled;
}

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

}  // namespace

Result<ShapeMeasures> MeasureShape(const TriangleMesh& mesh) {
  const Result<SurfaceSamples> samples = SampleSurface(mesh, kSamples, kSeed);
  if (!samples.ok()) return samples.error();
  const auto surface = ClosestTriangleSearch::Build(mesh);
  if (!surface.ok()) return surface.error();
  ShapeMeasures shape;
  shape.points = samples->points;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (const int corner : triangle)
      shape.vertices.push_back(mesh.vertices[static_cast<std::size_t>(corner)].cast<double>());
  }
  for (const Eigen::Vector3d& vertex : shape.vertices) shape.bounds.extend(vertex);
  for (const Eigen::Vector3d& point : shape.points) shape.centroid += point / kSamples;
  for (const int triangle : samples->triangles) {
    shape.normals.push_back((*surface)->Normal(triangle));
    const Eigen::Vector3d normal = shape.normals.back().cwiseAbs();
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

Stand StandOn(const ShapeMeasures& shape, const SignedAxis& up) {
  const int u = (up.axis + 1) % 3, v = (up.axis + 2) % 3;
  const double height = shape.bounds.sizes()[up.axis];
  const auto above = [&](const Eigen::Vector3d& point) {
    return up.sign > 0 ? point[up.axis] - shape.bounds.min()[up.axis]
                       : shape.bounds.max()[up.axis] - point[up.axis];
  };
  std::vector<Eigen::Vector2d> contacts, shadow;
  for (const auto* points : {&shape.points, &shape.vertices}) {
    for (const Eigen::Vector3d& point : *points) {
      if (above(point) <= 0.03 * height) contacts.emplace_back(point[u], point[v]);
      shadow.emplace_back(point[u], point[v]);
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
  stand.base_share = 0.5 * doubled_area / std::max(AreaOf(ConvexHull(shadow)), 1e-12);
  stand.feet = CountPieces(contacts, 0.1 * std::sqrt(0.5 * doubled_area));
  return stand;
}

}  // namespace plumbline
