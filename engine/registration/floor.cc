// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/floor.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include "engine/base/random.h"
#include "engine/geometry/gravity.h"
#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {
namespace {

constexpr float kAgreeingNormal = 0.9f;
constexpr double kLeastHint = 0.7;  // cos 45 degrees
constexpr std::size_t kFewestInliers = 20;

struct Plane {
  Eigen::Vector3d normal;
  double offset = 0;

  double Distance(const Eigen::Vector3f& point) const {
    return normal.dot(point.cast<double>()) + offset;
  }
};

struct PlaneFit {
  Plane plane;
  double rmse_m = 0, normal_std_rad = 0;
};

/// Least squares over the given points, Tukey's weights by the distance to `plane`.
std::optional<PlaneFit> Refit(const OrientedPoints& points, const std::vector<int>& indices,
                              const Plane& plane, double reach_m) {
  double weights = 0, squares = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moments = Eigen::Matrix3d::Zero();
  const Eigen::Vector3d origin =
      indices.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero())
                      : points.points[static_cast<std::size_t>(indices[0])].cast<double>();
  for (const int i : indices) {
    const Eigen::Vector3f& point = points.points[static_cast<std::size_t>(i)];
    const double distance = plane.Distance(point), share = distance / reach_m;
    if (std::abs(share) >= 1) continue;
    const double weight = (1 - share * share) * (1 - share * share);
    const Eigen::Vector3d p = point.cast<double>() - origin;
    mean += weight * p;
    moments += weight * p * p.transpose();
    squares += weight * distance * distance;
    weights += weight;
  }
  if (!(weights > 3)) return std::nullopt;
  mean /= weights;
  const auto [values, vectors] = EigenOf(moments / weights - mean * mean.transpose());
  const double middle = values[1];
  if (!(middle > 1e-10)) return std::nullopt;  // all on one line
  PlaneFit fit;
  fit.plane.normal = vectors.col(0);
  if (fit.plane.normal.dot(plane.normal) < 0) fit.plane.normal = -fit.plane.normal;
  fit.plane.offset = -fit.plane.normal.dot(mean + origin);
  fit.rmse_m = std::sqrt(squares / weights);
  fit.normal_std_rad = fit.rmse_m / std::sqrt(weights * middle);
  return fit;
}

bool Lies(const OrientedPoints& points, std::size_t i, const Plane& plane, double thickness_m) {
  return std::abs(plane.Distance(points.points[i])) < thickness_m &&
         std::abs(points.normals[i].dot(plane.normal.cast<float>())) > kAgreeingNormal;
}

/// Points on the plane that are connected to `seed` by steps of at most `step_m`, among `tree`'s.
std::vector<int> Connected(const OrientedPoints& points, const PointTree& tree, int seed,
                           const Plane& plane, double thickness_m, float step_m) {
  std::vector<char> seen(points.points.size(), 0);
  std::deque<int> open{seed};
  std::vector<int> found;
  seen[static_cast<std::size_t>(seed)] = 1;
  while (!open.empty()) {
    const int here = open.front();
    open.pop_front();
    found.push_back(here);
    for (const int i : tree.Within(points.points[static_cast<std::size_t>(here)], step_m)) {
      const auto k = static_cast<std::size_t>(i);
      if (seen[k]) continue;
      seen[k] = 1;
      if (Lies(points, k, plane, thickness_m)) open.push_back(i);
    }
  }
  return found;
}

/// The side on which the cameras are, else the hint's, else the bulk of the scene's.
Plane FacingTheScene(const OrientedPoints& points, Plane plane, const FloorHints& hints) {
  double above = 0;
  if (!hints.camera_centers.empty()) {
    for (const Eigen::Vector3d& center : hints.camera_centers) {
      above += plane.normal.dot(center) + plane.offset > 0 ? 1 : -1;
    }
  } else if (hints.up_in_scan) {
    above = plane.normal.dot(*hints.up_in_scan);
  } else {
    for (const Eigen::Vector3f& point : points.points) {
      const double distance = plane.Distance(point);
      if (std::abs(distance) > 0.1) above += distance > 0 ? 1 : -1;
    }
  }
  if (above < 0) {
    plane.normal = -plane.normal;
    plane.offset = -plane.offset;
  }
  return plane;
}

/// The final fit to all points of the scan.
Result<FloorPlane> Finish(const ScanTarget& scan, Plane plane, const FloorHints& hints,
                          double thickness_m) {
  const OrientedPoints& points = scan.points();
  FloorPlane floor;
  const auto collect = [&] {
    floor.inliers.clear();
    for (std::size_t i = 0; i < points.points.size(); ++i) {
      if (Lies(points, i, plane, thickness_m)) floor.inliers.push_back(static_cast<int>(i));
    }
  };
  for (int i = 0; i < 20; ++i) {
    collect();
    const std::optional<PlaneFit> fit = Refit(points, floor.inliers, plane, thickness_m);
    if (!fit || floor.inliers.size() < kFewestInliers) {
      return Error{ErrorCode::kDegenerate, "the scan has no plane there that could be a floor"};
    }
    const double change =
        (fit->plane.normal - plane.normal).norm() + std::abs(fit->plane.offset - plane.offset);
    plane = fit->plane;
    floor.rmse_m = fit->rmse_m;
    floor.normal_std_rad = fit->normal_std_rad;
    if (change < 1e-10) break;
  }
  collect();
  plane = FacingTheScene(points, plane, hints);
  floor.up_in_scan = plane.normal;
  floor.offset_m = plane.offset;
  return floor;
}

struct ScoredPlane {
  Plane plane;
  double score = 0;
};

/// The plane of most points with the scene on one side, for each direction; best first, three at
/// most.
std::vector<ScoredPlane> WidePlanes(const OrientedPoints& points, const FloorHints& hints,
                                    const FloorOptions& options) {
  constexpr int kTries = 600;
  constexpr double kSameDirection = 0.8;
  std::vector<ScoredPlane> planes;
  Random random({.seed = 1});
  for (int i = 0; i < kTries; ++i) {
    const auto k = random.Index(static_cast<std::uint32_t>(points.points.size()));
    Plane plane{points.normals[k].cast<double>(), 0};
    if (!(plane.normal.norm() > 0.5)) continue;
    if (hints.up_in_scan && std::abs(plane.normal.dot(*hints.up_in_scan)) < kLeastHint) continue;
    plane.offset = -plane.normal.dot(points.points[k].cast<double>());
    plane = FacingTheScene(points, plane, hints);
    std::size_t on = 0, above = 0, below = 0;
    for (std::size_t j = 0; j < points.points.size(); ++j) {
      const double distance = plane.Distance(points.points[j]);
      if (Lies(points, j, plane, options.thickness_m)) {
        ++on;
      } else if (std::abs(distance) > 2 * options.thickness_m) {
        ++(distance > 0 ? above : below);
      }
    }
    // A table's top is wide, too, but has the floor and its legs below.
    const double one_sided =
        static_cast<double>(above) / static_cast<double>(std::max<std::size_t>(1, above + below));
    const double score = static_cast<double>(on) * std::pow(one_sided, 8);
    const auto same = std::find_if(planes.begin(), planes.end(), [&](const ScoredPlane& other) {
      return std::abs(other.plane.normal.dot(plane.normal)) > kSameDirection;
    });
    if (same == planes.end()) {
      planes.push_back({plane, score});
    } else if (score > same->score) {
      *same = {plane, score};
    }
  }
  std::erase_if(planes, [](const ScoredPlane& plane) { return !(plane.score > 0); });
  std::stable_sort(planes.begin(), planes.end(),
                   [](const ScoredPlane& a, const ScoredPlane& b) { return a.score > b.score; });
  if (planes.size() > 3) planes.resize(3);
  return planes;
}

/// Tells the floor from bare walls by everything else: whatever way furniture is turned, its sides
/// stand across the floor and its tops lie along it, while to a wall they may stand at any angle.
void WeighByTheRest(const OrientedPoints& points, double thickness_m,
                    std::vector<ScoredPlane>& planes) {
  constexpr float kAlong = 0.94f, kAcross = 0.2f;  // 20 and 78 degrees
  constexpr std::size_t kFewest = 200;
  std::vector<std::size_t> rest;
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    const bool on_any =
        std::any_of(planes.begin(), planes.end(), [&](const ScoredPlane& candidate) {
          return std::abs(candidate.plane.Distance(points.points[i])) < 2 * thickness_m;
        });
    if (!on_any && points.normals[i].norm() > 0.5f) rest.push_back(i);
  }
  if (rest.size() < kFewest) return;
  // The more there is of the rest, the more it tells.
  const double trust = std::min(
      6.0, 12.0 * static_cast<double>(rest.size()) / static_cast<double>(points.points.size()));
  for (ScoredPlane& candidate : planes) {
    const Eigen::Vector3f normal = candidate.plane.normal.cast<float>();
    const auto square = std::count_if(rest.begin(), rest.end(), [&](std::size_t i) {
      const float cosine = std::abs(points.normals[i].dot(normal));
      return cosine > kAlong || cosine < kAcross;
    });
    candidate.score *=
        std::pow(static_cast<double>(square) / static_cast<double>(rest.size()), trust);
  }
  std::stable_sort(planes.begin(), planes.end(),
                   [](const ScoredPlane& a, const ScoredPlane& b) { return a.score > b.score; });
}

}  // namespace

Eigen::Isometry3d FloorPlane::WorldFromScan() const {
  Eigen::Isometry3d world_from_scan = Eigen::Isometry3d::Identity();
  world_from_scan.linear() = UprightFrame(-up_in_scan).upright_rotation().transpose();
  world_from_scan.translation().z() = offset_m;
  return world_from_scan;
}

Result<FloorPlane> FitFloorFrom(const ScanTarget& scan, const Eigen::Vector3d& seed_in_scan,
                                const FloorHints& hints, const FloorOptions& options) {
  constexpr float kVoxel_m = 0.03f;
  const Error none{ErrorCode::kDegenerate,
                   "there is no plane around the point given; choose one on the open floor"};
  // A coarse copy: growing visits every point's neighbours.
  const OrientedPoints points =
      Select(scan.points(), VoxelSample(scan.points().points, kVoxel_m, 200'000));
  const PointTree tree(points.points);
  const PointTree::Neighbor nearest = tree.Nearest(seed_in_scan.cast<float>());
  if (std::sqrt(nearest.squared_distance) > options.seed_radius_m) return none;
  const auto seed = static_cast<std::size_t>(nearest.index);
  Plane plane{points.normals[seed].cast<double>(), 0};
  plane.offset = -plane.normal.dot(points.points[seed].cast<double>());
  std::vector<int> patch =
      tree.Within(points.points[seed], static_cast<float>(options.seed_radius_m));
  for (int round = 0; round < 15; ++round) {
    // Wide at first: one normal points only roughly the right way.
    const double reach = options.thickness_m * (round < 3 ? 2 : 1);
    for (int i = 0; i < 5; ++i) {
      const std::optional<PlaneFit> fit = Refit(points, patch, plane, reach);
      if (!fit) return none;
      plane = fit->plane;
    }
    std::vector<int> grown =
        Connected(points, tree, nearest.index, plane, options.thickness_m, 2.5f * kVoxel_m);
    std::sort(grown.begin(), grown.end());
    if (grown == patch) break;
    patch = std::move(grown);
  }
  if (patch.size() < kFewestInliers) return none;
  return Finish(scan, plane, hints, options.thickness_m);
}

Result<FloorPlane> FindFloor(const ScanTarget& scan, const FloorHints& hints,
                             const FloorOptions& options) {
  constexpr float kVoxel_m = 0.06f;
  const OrientedPoints points =
      Select(scan.points(), VoxelSample(scan.points().points, kVoxel_m, 20'000));
  std::vector<ScoredPlane> planes = WidePlanes(points, hints, options);
  if (planes.empty()) {
    return Error{ErrorCode::kDegenerate,
                 "the scan has no plane that could be a floor; give a point on it"};
  }
  const bool guessed = hints.camera_centers.empty() && !hints.up_in_scan;
  if (guessed) WeighByTheRest(points, options.thickness_m, planes);
  Result<FloorPlane> floor = Finish(scan, planes[0].plane, hints, options.thickness_m);
  if (!floor) return floor;
  floor->guessed = guessed;
  if (planes.size() > 1) floor->rival = planes[1].score / planes[0].score;
  return floor;
}

std::optional<Eigen::Vector3d> UpOfCameras(const std::vector<Eigen::Isometry3d>& scan_from_cam) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Isometry3d& pose : scan_from_cam) sum -= pose.linear().col(1);
  if (!(sum.norm() > 0.3 * static_cast<double>(scan_from_cam.size()))) return std::nullopt;
  return sum.normalized();
}

}  // namespace plumbline
