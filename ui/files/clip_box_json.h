// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

namespace plumbline {

/// An upright box: nothing outside of it is drawn, but for grid and camera.
struct ClipBox {
  Eigen::Matrix3d world_from_upright = Eigen::Matrix3d::Identity();
  Eigen::AlignedBox3d in_upright;
  bool Holds(const Eigen::Vector3d& point_in_world) const {
    return in_upright.contains(Eigen::Vector3d(world_from_upright.transpose() * point_in_world));
  }
  bool operator==(const ClipBox& other) const {
    return world_from_upright == other.world_from_upright &&
           in_upright.min() == other.in_upright.min() && in_upright.max() == other.in_upright.max();
  }
};

/// World's axes of the box and its corners [m].
nlohmann::json ToJson(const ClipBox& box);
/// Nothing for what is no box, or is farther than kFarthest_m.
std::optional<ClipBox> ClipBoxFromJson(const nlohmann::json& json);

}  // namespace plumbline
