// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plumbline {

/// The ground under a path, and how well a plane describes it.
struct PathFloor {
  Eigen::Vector4d floor_in_world{0, 0, 1, 0};  ///< (a, b, c, d), (a, b, c) a unit vector up.
  double std_m = 0;                            ///< Of the path's heights over the plane.
};

/// The plane on which a camera goes that is carried at a known height over it, as on a car: fitted
/// to its positions by least squares and lowered by that height. It slopes along the path; across a
/// straight path, where nothing tells of a slope, it is level (slopes have the deviation of a
/// road's, 3 per cent). Nothing where there are no positions, or where no plane describes the
/// ground: heights off it by more than half a metre (rms).
///
/// @param world_from_cam  Along the path; those that are missing are passed over.
/// @param up_in_world     Unit vector.
/// @param height_m        Of the camera over the ground.
std::optional<PathFloor> FloorUnderPath(
    std::span<const std::optional<Eigen::Isometry3d>> world_from_cam,
    const Eigen::Vector3d& up_in_world, double height_m);

}  // namespace plumbline
