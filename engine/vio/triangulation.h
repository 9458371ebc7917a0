// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/sensor/distorted_camera.h"

namespace plumbline {

/// One sight of a point.
struct Sight {
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray;  ///< Unproject(pixel)
};

struct TriangulationOptions {
  double pixel_noise_px = 1;
  double min_depth_m = 0.1, max_depth_m = 100;
  double max_depth_spread = 0.5;  ///< Standard deviation of the inverse depth, relatively.
  double outlier_sigmas = 4;      ///< Sights farther off than this are left out.
};

struct TriangulatedPoint {
  Eigen::Vector3d point_in_world;
  /// In the camera of the last sight used: (X/Z, Y/Z, 1/Z).
  Eigen::Vector3d bearing_and_inverse_depth;
  std::vector<bool> used;  ///< One for each sight; at least two thirds of them are.
};

/// The point that was seen, by least squares of pixels over (X/Z, Y/Z, 1/Z) of the last sight,
/// from a linear start; a mismatch among the sights is left out. Nothing where there are fewer than
/// two sights, where the point is behind a camera or nearer than it may be, where its depth is too
/// uncertain (no parallax), or where more than a third of the sights disagree.
std::optional<TriangulatedPoint> Triangulate(const DistortedCamera& camera,
                                             std::span<const Sight> sights,
                                             const TriangulationOptions& options);

}  // namespace plumbline
