// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/sensor/pose_estimate.h"
#include "engine/vio/pose_graph.h"

namespace plumbline {

/// A turn about up and a shift of `world`: new_world_from_world.
struct YawMove {
  double yaw_rad = 0;
  Eigen::Vector3d shift_m{0, 0, 0};

  Eigen::Isometry3d AsIsometry() const;
};

/// The move that takes a filter's pose to that of a key frame in the graph.
YawMove MoveTo(const GraphPose& corrected, const Eigen::Vector3d& filter_position_in_world);

/// What a trajectory is corrected by after loops were closed: between two key frames the move
/// changes evenly with time, so that nothing jumps. Roll and pitch stay the filter's.
class TrajectoryCorrection {
 public:
  struct Node {
    std::int64_t stamp_ns = 0;
    Eigen::Vector3d filter_position_in_world{0, 0, 0};
    GraphPose corrected;
    /// Of the corrected pose, order (x, y, z, yaw), since the trajectory's beginning.
    Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  };

  TrajectoryCorrection() = default;
  /// @param nodes  By rising stamp.
  explicit TrajectoryCorrection(std::vector<Node> nodes) : nodes_(std::move(nodes)) {}

  /// Nothing was corrected: poses and covariances stay the filter's.
  bool empty() const { return nodes_.empty(); }

  /// corrected_world_from_world at an image, for what was seen near the body.
  Eigen::Isometry3d At(std::int64_t stamp_ns, const Eigen::Vector3d& position_in_world) const;

  /// The covariance of a corrected pose, order of PosePerturbation: heading and position of the
  /// body from the graph, tilt from the filter; what ties tilt to position is left out.
  PoseCovariance CovarianceAt(std::int64_t stamp_ns, const PoseCovariance& of_filter) const;

 private:
  struct Between {
    const Node &before, &after;
    double share;  ///< Of `after`.
  };
  Between Around(std::int64_t stamp_ns) const;

  std::vector<Node> nodes_;
};

}  // namespace plumbline
