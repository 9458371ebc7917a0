// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/scanned_surface.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/evaluation/posed_scene.h"
#include "engine/geometry/surface_sampling.h"

namespace plumbline {
namespace {

/// Drawn points of the scan are this far apart on average: a place that was scanned has none within
/// kScanSpacing_m once in 300 000.
constexpr double kDrawnSpacing_m = 0.005;
constexpr double kMostDrawn = 4e6;
/// A floor is not a chair's leg: directions further apart than 60 degrees do not go together.
constexpr double kLeastCosine = 0.5;

/// The triangles of the scan that come near a true object.
TriangleMesh NearTruth(const TriangleMesh& scan, std::span<const PosedModel> truth) {
  std::vector<Eigen::AlignedBox3f> boxes;
  for (const PosedModel& posed : truth) {
    PosedScene one;
    one.Add(posed.model->mesh, posed.scene_from_object, posed.scale, 0);
    Eigen::AlignedBox3f box = BoundingBox(one.mesh);
    const Eigen::Vector3f reach = Eigen::Vector3f::Constant(static_cast<float>(kScanReach_m));
    boxes.emplace_back(box.min() - reach, box.max() + reach);
  }
  TriangleMesh near;
  near.vertices = scan.vertices;
  for (const Eigen::Vector3i& triangle : scan.triangles) {
    Eigen::AlignedBox3f box;
    for (const int corner : triangle) box.extend(scan.vertices[static_cast<std::size_t>(corner)]);
    const bool meets = std::any_of(boxes.begin(), boxes.end(),
                                   [&](const auto& other) { return other.intersects(box); });
    if (meets) near.triangles.push_back(triangle);
  }
  return near;
}

}  // namespace

Result<ScannedSurface> ScannedSurface::Build(const TriangleMesh& scan,
                                             std::span<const PosedModel> truth) {
  PosedScene scene;
  for (const PosedModel& posed : truth)
    scene.Add(posed.model->mesh, posed.scene_from_object, posed.scale, 0);
  auto surface = ClosestTriangleSearch::Build(scene.mesh);
  if (!surface) return surface.error();
  const TriangleMesh near = NearTruth(scan, truth);
  const double area = SurfaceArea(near);
  if (!(area > 0)) return ScannedSurface(std::move(*surface), {});
  const double wanted = std::ceil(area / (kDrawnSpacing_m * kDrawnSpacing_m));
  const Result<SurfaceSamples> drawn =
      SampleSurface(near, static_cast<int>(std::min(wanted, kMostDrawn)), 0);
  if (!drawn) return drawn.error();
  std::vector<ClosestPoint> closest(drawn->points.size());
  (*surface)->Find(drawn->points, closest);
  std::vector<Eigen::Vector3f> places;
  for (std::size_t i = 0; i < closest.size(); ++i) {
    if (closest[i].distance_m > kScanReach_m) continue;
    const Eigen::Vector3i& t = near.triangles[static_cast<std::size_t>(drawn->triangles[i])];
    const auto corner = [&](int k) {
      return near.vertices[static_cast<std::size_t>(t[k])].cast<double>().eval();
    };
    const Eigen::Vector3d in_scan =
        (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    const double cosine = in_scan.dot((*surface)->Normal(closest[i].triangle));
    if (std::abs(cosine) >= kLeastCosine) places.push_back(closest[i].point.cast<float>());
  }
  return ScannedSurface(std::move(*surface), std::move(places));
}

bool ScannedSurface::At(const Eigen::Vector3d& place_on_truth) const {
  const PointTree::Neighbor nearest = places_.Nearest(place_on_truth.cast<float>());
  return nearest.index >= 0 && nearest.squared_distance <= kScanSpacing_m * kScanSpacing_m;
}

}  // namespace plumbline
