// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/surface_gap.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/geometry/surface_sampling.h"

namespace plumbline {
namespace {

using Eigen::Affine3d;
using Eigen::Vector3d;

constexpr int kPoints = 400, kTreePoints = 6000;
constexpr std::size_t kStarts = 12;
constexpr int kMostSteps = 60;
constexpr double kConverged_m = 1e-7;

/// A mesh in whose frame distances are `scale` times as long in the world.
struct Side {
  const ClosestTriangleSearch& triangles;
  double scale;
};

/// From a point of `from` to the other surface and back, for as long as it gets closer. Both
/// transforms lead from one mesh's frame to the other's.
double Descend(Vector3d point, const Affine3d& to_from_from, const Side& from, const Side& to) {
  const Affine3d from_from_to = to_from_from.inverse();
  double distance = 1e9;
  for (int step = 0; step < kMostSteps; ++step) {
    const ClosestPoint there = to.triangles.Find(to_from_from * point);
    const ClosestPoint back = from.triangles.Find(from_from_to * there.point);
    point = back.point;
    const double now = std::min(to.scale * there.distance_m, from.scale * back.distance_m);
    if (now > distance - kConverged_m) return std::min(now, distance);
    distance = now;
  }
  return distance;
}

}  // namespace

Result<std::unique_ptr<MeasuredSurface>> MeasuredSurface::Make(const TriangleMesh& mesh) {
  auto many = SampleSurface(mesh, kTreePoints, 1);
  if (!many.ok()) return many.error();
  auto triangles = ClosestTriangleSearch::Build(mesh);
  if (!triangles.ok()) return triangles.error();
  std::vector<Eigen::Vector3f> points;
  for (const Vector3d& point : many->points) points.push_back(point.cast<float>());
  // Corners are closest to something far more often than their share of the area says.
  for (const Eigen::Vector3f& vertex : mesh.vertices) points.push_back(vertex);
  std::unique_ptr<MeasuredSurface> surface(new MeasuredSurface(PointTree(std::move(points))));
  surface->points_.assign(many->points.begin(), many->points.begin() + kPoints);
  surface->triangles_ = std::move(triangles).value();
  surface->box_ = BoundingBox(mesh).cast<double>();
  return surface;
}

double SurfaceGap(const PlacedSurface& a, const PlacedSurface& b) {
  const Affine3d b_from_a = b.world_from_mesh().inverse() * a.world_from_mesh();
  const Affine3d a_from_b = b_from_a.inverse();
  struct Start {
    double distance_m;
    Vector3d point;  ///< In a's mesh.
  };
  std::vector<Start> starts;
  for (const Vector3d& point : a.surface.points_) {
    const auto near = b.surface.tree_.Nearest((b_from_a * point).cast<float>());
    starts.push_back({b.scale * std::sqrt(near.squared_distance), point});
  }
  for (const Vector3d& point : b.surface.points_) {
    const auto near = a.surface.tree_.Nearest((a_from_b * point).cast<float>());
    starts.push_back(
        {a.scale * std::sqrt(near.squared_distance),
         a.surface.tree_.points()[static_cast<std::size_t>(near.index)].cast<double>()});
  }
  const auto last = starts.begin() + static_cast<std::ptrdiff_t>(std::min(kStarts, starts.size()));
  std::partial_sort(starts.begin(), last, starts.end(),
                    [](const Start& x, const Start& y) { return x.distance_m < y.distance_m; });
  double gap = 1e9;
  for (auto start = starts.begin(); start != last; ++start) {
    gap = std::min(gap, Descend(start->point, b_from_a, {*a.surface.triangles_, a.scale},
                                {*b.surface.triangles_, b.scale}));
  }
  return gap;
}

double GapAtLeast(const PlacedSurface& a, const PlacedSurface& b) {
  const Eigen::AlignedBox3d &box_a = a.surface.box(), &box_b = b.surface.box();
  const double centers =
      (a.world_from_mesh() * box_a.center() - b.world_from_mesh() * box_b.center()).norm();
  return std::max(
      0.0, centers - 0.5 * (a.scale * box_a.diagonal().norm() + b.scale * box_b.diagonal().norm()));
}

}  // namespace plumbline
