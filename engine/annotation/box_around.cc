// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/box_around.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/geometry/gravity.h"
#include "engine/geometry/point_tree.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;
using Cell = std::array<int, 3>;

constexpr double kReach_m =
    1.3;  ///< Along the floor; what goes on beyond is no piece of furniture.
constexpr double kFloorThickness_m = 0.03, kStandsWithin_m = 0.12, kSpare_m = 0.01;
/// Gaps of up to twice this are bridged; the widest that keeps the thing apart from others, but no
/// less than so many times the distance between points, which would take surfaces to pieces.
constexpr double kVoxels_m[] = {0.03, 0.02, 0.015, 0.01};
constexpr double kVoxelInSpacings = 1;
constexpr double kSpacingWithin_m = 0.3;  ///< Of the point.
constexpr double kAtPoint_m = 0.1;        ///< From a click to what was meant.
constexpr double kWallHeight_m = 1.5;     ///< Filled in one column.
constexpr double kColumn_m = 0.08, kBin_m = 0.1;
/// A support shows in so much of the ring about the point, and lies so much below it.
constexpr double kRingFrom_m = 0.15, kRingTo_m = 0.3, kRingShare = 0.6, kRingCell_m = 0.05;
constexpr double kSupportBelow_m = 0.4, kSupportThickness_m = 0.015;
constexpr double kLevel = 0.9, kUpright = 0.4;  ///< Cosines of a normal to up.

Cell CellOf(const Vector3d& p, double side_m) {
  return {static_cast<int>(std::floor(p.x() / side_m)),
          static_cast<int>(std::floor(p.y() / side_m)),
          static_cast<int>(std::floor(p.z() / side_m))};
}

/// A point of the scan in the level frame, with the point that was clicked as origin.
struct LevelPoint {
  Vector3d at;
  double normal_up;  ///< Cosine.
};

std::vector<LevelPoint> PointsNear(const ScanTarget& scan, const Vector3d& point,
                                   const Eigen::Matrix3d& level_from_scan) {
  std::vector<LevelPoint> near;
  const auto& points = scan.points();
  for (std::size_t i = 0; i < points.points.size(); ++i) {
    const Vector3d at = level_from_scan * (points.points[i].cast<double>() - point);
    if (at.head<2>().norm() > kReach_m) continue;
    near.push_back({at, std::abs(level_from_scan.row(2).dot(points.normals[i].cast<double>()))});
  }
  return near;
}

/// The columns of walls: upright surface over most of the height of a room.
std::set<std::pair<int, int>> Walls(const std::vector<LevelPoint>& points) {
  std::map<std::pair<int, int>, std::set<int>> bins;
  for (const LevelPoint& p : points) {
    if (p.normal_up > kUpright) continue;
    const Cell cell = CellOf(p.at, kColumn_m);
    bins[{cell[0], cell[1]}].insert(static_cast<int>(std::floor(p.at.z() / kBin_m)));
  }
  std::set<std::pair<int, int>> walls;
  for (const auto& [column, filled] : bins) {
    if (static_cast<double>(filled.size()) * kBin_m >= kWallHeight_m) walls.insert(column);
  }
  return walls;
}

/// Height of a level surface that lies all around below the point; nothing where there is none.
std::optional<double> SupportBelow(const std::vector<LevelPoint>& points) {
  std::map<int, std::set<std::pair<int, int>>> bins;
  std::map<int, std::vector<double>> heights;
  for (const LevelPoint& p : points) {
    const double radius_m = p.at.head<2>().norm();
    if (p.normal_up < kLevel || radius_m < kRingFrom_m || radius_m > kRingTo_m) continue;
    if (p.at.z() > -2 * kSupportThickness_m || p.at.z() < -kSupportBelow_m) continue;
    const Cell cell = CellOf(p.at, kRingCell_m);
    const int bin = static_cast<int>(std::floor(p.at.z() / (2 * kSupportThickness_m)));
    bins[bin].insert({cell[0], cell[1]});
    heights[bin].push_back(p.at.z());
  }
  const double ring_m2 = std::numbers::pi * (kRingTo_m * kRingTo_m - kRingFrom_m * kRingFrom_m);
  std::optional<double> support_m;
  for (auto bin = bins.rbegin(); bin != bins.rend() && !support_m; ++bin) {
    std::set<std::pair<int, int>> cells = bin->second;
    std::vector<double> all = heights[bin->first];
    if (const auto below = bins.find(bin->first - 1);
        below != bins.end()) {  // it may be cut by one
      cells.insert(below->second.begin(), below->second.end());
      all.insert(all.end(), heights[below->first].begin(), heights[below->first].end());
    }
    const double share = static_cast<double>(cells.size()) * kRingCell_m * kRingCell_m / ring_m2;
    if (share < kRingShare) continue;
    std::nth_element(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2),
                     all.end());
    support_m = all[all.size() / 2];
  }
  return support_m;
}

/// What hangs together with the cells near the origin.
std::set<Cell> GrownFromOrigin(const std::set<Cell>& filled, double side_m) {
  std::set<Cell> grown;
  std::vector<Cell> open;
  for (const Cell& cell : filled) {
    const Vector3d middle = side_m * (Vector3d(cell[0], cell[1], cell[2]).array() + 0.5).matrix();
    if (middle.norm() < kAtPoint_m && grown.insert(cell).second) open.push_back(cell);
  }
  while (!open.empty()) {
    const Cell from = open.back();
    open.pop_back();
    for (int i = 0; i < 27; ++i) {
      const Cell next{from[0] + i % 3 - 1, from[1] + i / 3 % 3 - 1, from[2] + i / 9 - 1};
      if (filled.count(next) > 0 && grown.insert(next).second) open.push_back(next);
    }
  }
  return grown;
}

/// The distance that nine of ten points near the origin have to their nearest neighbour.
double SpacingAtOrigin(const std::vector<LevelPoint>& points) {
  std::vector<Eigen::Vector3f> near;
  for (const LevelPoint& p : points) {
    if (p.at.norm() < kSpacingWithin_m) near.push_back(p.at.cast<float>());
  }
  if (near.size() < 3) return 0;
  const PointTree tree(near);
  std::vector<double> distances;
  for (const Eigen::Vector3f& p : near)
    distances.push_back(std::sqrt(tree.Nearest(p, 2)[1].squared_distance));
  const auto at = distances.begin() + static_cast<std::ptrdiff_t>(0.9 * double(near.size() - 1));
  std::nth_element(distances.begin(), at, distances.end());
  return *at;
}

std::vector<Vector3d> ThingAtOrigin(const std::vector<LevelPoint>& points, double voxel_m) {
  std::set<Cell> filled;
  for (const LevelPoint& p : points) filled.insert(CellOf(p.at, voxel_m));
  const std::set<Cell> grown = GrownFromOrigin(filled, voxel_m);
  std::vector<Vector3d> thing;
  for (const LevelPoint& p : points) {
    if (grown.count(CellOf(p.at, voxel_m)) > 0) thing.push_back(p.at);
  }
  return thing;
}

}  // namespace

Result<CropBox> BoxAround(const ScanTarget& scan, const Vector3d& point_in_scan,
                          const BoxSurroundings& surroundings) {
  const Eigen::Matrix3d level_from_scan =
      UprightFrame(-surroundings.up_in_scan).upright_rotation().transpose();
  std::vector<LevelPoint> points = PointsNear(scan, point_in_scan, level_from_scan);
  std::optional<double> floor_m;
  if (const auto& floor = surroundings.floor_in_scan)
    floor_m = -(floor->head<3>().dot(point_in_scan) + (*floor)[3]);
  const std::optional<double> support_m = SupportBelow(points);
  double lowest_m = floor_m.value_or(-1e9) + kFloorThickness_m;
  if (support_m) lowest_m = std::max(lowest_m, *support_m + kSupportThickness_m);
  const auto walls = Walls(points);
  std::erase_if(points, [&](const LevelPoint& p) {
    const Cell column = CellOf(p.at, kColumn_m);
    return p.at.z() < lowest_m || walls.count({column[0], column[1]}) > 0;
  });

  std::vector<Vector3d> thing;
  bool hangs_together = false;
  const double least_m = kVoxelInSpacings * SpacingAtOrigin(points);
  for (const double wanted_m : kVoxels_m) {
    const double voxel_m = std::max(wanted_m, least_m);
    thing = ThingAtOrigin(points, voxel_m);
    if (thing.empty()) break;
    const bool apart = std::none_of(thing.begin(), thing.end(), [&](const Vector3d& p) {
      return p.head<2>().norm() > kReach_m - voxel_m;
    });
    if (apart) break;
    thing.clear();
    hangs_together = true;
  }
  if (thing.empty()) {
    return Error{ErrorCode::kDegenerate, hangs_together
                                             ? "what was clicked hangs together with other things"
                                             : "nothing but floor or wall was clicked"};
  }
  std::vector<cv::Point2f> plan;
  double bottom_m = 1e9, top_m = -1e9;
  for (const Vector3d& p : thing) {
    plan.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    bottom_m = std::min(bottom_m, p.z());
    top_m = std::max(top_m, p.z());
  }
  if (floor_m && bottom_m - *floor_m < kStandsWithin_m) {
    bottom_m = *floor_m;
  } else if (floor_m && !(support_m && bottom_m - *support_m < kStandsWithin_m)) {
    return Error{ErrorCode::kDegenerate,
                 "what was clicked does not reach down to what it stands on"};
  }

  const cv::RotatedRect least = cv::minAreaRect(plan);
  const double angle = least.angle * std::numbers::pi / 180;
  const double quarters =
      std::round((surroundings.view_azimuth_rad - angle) / (0.5 * std::numbers::pi));
  const bool across = static_cast<long>(quarters) % 2 != 0;
  CropBox box;
  box.azimuth_rad = WrapAngle(angle + quarters * 0.5 * std::numbers::pi);
  box.size_m = {across ? least.size.height : least.size.width,
                across ? least.size.width : least.size.height, top_m - bottom_m};
  box.size_m.array() += 2 * kSpare_m;
  const Vector3d center(least.center.x, least.center.y, 0.5 * (bottom_m + top_m));
  box.center_in_scan = point_in_scan + level_from_scan.transpose() * center;
  return box;
}

}  // namespace plumbline
