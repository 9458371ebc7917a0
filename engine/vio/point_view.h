// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/sensor/distorted_camera.h"

namespace plumbline {

/// The pixel in which a camera on a body sees a point, and how it moves with each error of
/// docs/algorithms/vio.md.
struct PointView {
  Eigen::Vector2d pixel;
  Eigen::Vector3d point_in_cam;
  Eigen::Matrix<double, 2, 6> by_pose;    ///< (phi, xi_p) of world_from_body.
  Eigen::Matrix<double, 2, 6> by_camera;  ///< (theta, d) of body_from_cam.
  Eigen::Matrix<double, 2, 3> by_point;   ///< The point in `world`.
};

/// Nothing where the camera does not see the point.
std::optional<PointView> ViewPoint(const DistortedCamera& camera,
                                   const Eigen::Isometry3d& body_from_cam,
                                   const Eigen::Isometry3d& world_from_body,
                                   const Eigen::Vector3d& point_in_world);

/// A point of the state, (X/Z, Y/Z, 1/Z) in its anchor's camera, moved by an error: that of its
/// depth is of the logarithm, so that a wrong scale of everything is the same error of each point,
/// whatever its depth is thought to be.
Eigen::Vector3d MovedPoint(const Eigen::Vector3d& bearing_and_inverse_depth,
                           const Eigen::Vector3d& error);

/// A point of the state, which hangs on its anchor, in `world`.
struct AnchoredPoint {
  Eigen::Vector3d point_in_world;
  Eigen::Matrix<double, 3, 6> by_anchor;  ///< (phi, xi_p) of the anchor's world_from_body.
  Eigen::Matrix<double, 3, 6> by_camera;
  Eigen::Matrix3d by_value;  ///< The error of MovedPoint().
};

AnchoredPoint PlacePoint(const Eigen::Isometry3d& body_from_cam,
                         const Eigen::Isometry3d& world_from_body,
                         const Eigen::Vector3d& bearing_and_inverse_depth);

/// The same point in the chart of another anchor; PlacePoint the other way round.
struct PointChart {
  Eigen::Vector3d bearing_and_inverse_depth;
  Eigen::Matrix<double, 3, 6> by_anchor;  ///< Rows: the error of MovedPoint().
  Eigen::Matrix<double, 3, 6> by_camera;
  Eigen::Matrix3d by_point;
};

/// Nothing for a point that is not in front of the camera.
std::optional<PointChart> ChartPoint(const Eigen::Isometry3d& body_from_cam,
                                     const Eigen::Isometry3d& world_from_body,
                                     const Eigen::Vector3d& point_in_world);

}  // namespace plumbline
