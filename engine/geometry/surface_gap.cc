// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/surface_gap.h"

#include <algorithm>
#include <utility>

#include "engine/geometry/surface_sampling.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr int kPoints = 400, kTreePoints = 6000;
constexpr std::size_t kStarts = 12;
constexpr int kMostSteps = 60;
constexpr double kConverged_m = 1e-7;

/// From a point of `from` to the other surface and back, for as long as it gets closer. Both
/// transforms lead from one mesh's frame to the other's.
double Descend(Vector3d point, const Isometry3d& to_from_from, const ClosestTriangleSearch& from,
               const ClosestTriangleSearch& to) {
  const Isometry3d from_from_to = to_from_from.inverse();
  double distance = 1e9;
  for (int step = 0; step < kMostSteps; ++step) {
    const ClosestPoint there = to.Find(to_from_from * point);
    const ClosestPoint back = from.Find(from_from_to * there.point);
    point = back.point;
    const double now = std::min(there.distance_m, back.distance_m);
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

double SurfaceGap(const MeasuredSurface& a, const Isometry3d& world_from_a,
                  const MeasuredSurface& b, const Isometry3d& world_from_b) {
  const Isometry3d b_from_a = world_from_b.inverse() * world_from_a;
  struct Start {
    float squared;
    Vector3d point;  ///< In a's frame.
  };
  std::vector<Start> starts;
  for (const Vector3d& point : a.points_)
    starts.push_back({b.tree_.Nearest((b_from_a * point).cast<float>()).squared_distance, point});
  const Isometry3d a_from_b = b_from_a.inverse();
  for (const Vector3d& point : b.points_) {
    const auto near = a.tree_.Nearest((a_from_b * point).cast<float>());
    starts.push_back({near.squared_distance,
                      a.tree_.points()[static_cast<std::size_t>(near.index)].cast<double>()});
  }
  const auto last = starts.begin() + static_cast<std::ptrdiff_t>(std::min(kStarts, starts.size()));
  std::partial_sort(starts.begin(), last, starts.end(),
                    [](const Start& x, const Start& y) { return x.squared < y.squared; });
  double gap = 1e9;
  for (auto start = starts.begin(); start != last; ++start)
    gap = std::min(gap, Descend(start->point, b_from_a, *a.triangles_, *b.triangles_));
  return gap;
}

double GapAtLeast(const MeasuredSurface& a, const Isometry3d& world_from_a,
                  const MeasuredSurface& b, const Isometry3d& world_from_b) {
  const double centers = (world_from_a * a.box_.center() - world_from_b * b.box_.center()).norm();
  return std::max(0.0, centers - 0.5 * (a.box_.diagonal().norm() + b.box_.diagonal().norm()));
}

}  // namespace plumbline
