// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/path_floor.h"

#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

constexpr double kSlopeStd = 0.03;     ///< Of roads.
constexpr double kHeightStd_m = 0.03;  ///< Of a carried camera over its mean.
constexpr double kMostRms_m = 0.5;

}  // namespace

std::optional<PathFloor> FloorUnderPath(
    std::span<const std::optional<Eigen::Isometry3d>> world_from_cam,
    const Eigen::Vector3d& up_in_world, double height_m) {
  std::vector<Eigen::Vector3d> positions_in_world;
  for (const std::optional<Eigen::Isometry3d>& pose : world_from_cam) {
    if (pose) positions_in_world.push_back(pose->translation());
  }
  if (positions_in_world.empty()) return std::nullopt;
  const Eigen::Matrix3d upright_from_world =
      UprightFrame(-up_in_world).upright_rotation().transpose();
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& position : positions_in_world) middle += position;
  middle /= static_cast<double>(positions_in_world.size());
  // height = slope . (x, y) about the middle; the prior keeps the slope where nothing tells of it.
  Eigen::Matrix2d squares = Eigen::Matrix2d::Identity() * std::pow(kHeightStd_m / kSlopeStd, 2);
  Eigen::Vector2d products = Eigen::Vector2d::Zero();
  for (const Eigen::Vector3d& position : positions_in_world) {
    const Eigen::Vector3d off = upright_from_world * (position - middle);
    squares += off.head<2>() * off.head<2>().transpose();
    products += off.z() * off.head<2>();
  }
  const Eigen::Vector2d slope = squares.ldlt().solve(products);
  const Eigen::Vector3d normal =
      upright_from_world.transpose() * Eigen::Vector3d(-slope.x(), -slope.y(), 1).normalized();
  double sum = 0;
  for (const Eigen::Vector3d& position : positions_in_world)
    sum += std::pow(normal.dot(position - middle), 2);
  PathFloor floor;
  floor.std_m = std::sqrt(sum / static_cast<double>(positions_in_world.size()));
  if (!(floor.std_m <= kMostRms_m)) return std::nullopt;
  floor.floor_in_world << normal, height_m - normal.dot(middle);
  return floor;
}

}  // namespace plumbline
