// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/sensor/camera.h"
#include "engine/sensor/distorted_camera.h"
#include "engine/vio/loop_options.h"
#include "engine/vio/place_frame.h"

namespace plumbline {

/// A point of an older key frame that looks like a corner of another image.
struct PointMatch {
  int point = 0;   ///< Index into the older key frame's points_in_body.
  int corner = 0;  ///< Index into the other's corners.
};

/// Where a key frame was, by the points of an older one: in the world of that one's filter pose.
struct PlaceMatch {
  double yaw_rad = 0;  ///< By which the filter's attitude is turned about up.
  Eigen::Vector3d position_in_world{0, 0, 0};
  /// Order (x, y, z, yaw), of the position and the yaw.
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  int inliers = 0;
};

/// Points of the older key frame that look like one corner of the other and unlike all its others,
/// each corner once (brute force over ORB's Hamming distances).
std::vector<PointMatch> MatchPoints(const PlaceFrame& older, const PlaceFrame& seen);

/// Finds the pose of `seen` from matches: perspective-n-point in RANSAC (OpenCV's, with its fixed
/// seed), which has to have gravity where the filter has it; then least squares of pixels over yaw
/// and position alone, the filter's roll and pitch kept, Huber's weights. Deterministic. Nothing
/// where too few points agree, gravity is off, or they lie too close together to hold a pose.
std::optional<PlaceMatch> LocateByPoints(const DistortedCamera& camera, double focal_px,
                                         const PlaceFrame& older, const PlaceFrame& seen,
                                         const std::vector<PointMatch>& matches,
                                         const LoopOptions& options);

}  // namespace plumbline
