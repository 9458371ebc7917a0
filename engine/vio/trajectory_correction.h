// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
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

/// Where closed loops moved a trajectory: between two key frames the move changes evenly with time,
/// so that nothing jumps. Roll and pitch stay the filter's.
class TrajectoryMoves {
 public:
  struct Node {
    std::int64_t stamp_ns = 0;
    Eigen::Vector3d filter_position_in_world{0, 0, 0};
    GraphPose corrected;
  };

  TrajectoryMoves() = default;
  /// @param nodes  By rising stamp.
  explicit TrajectoryMoves(std::vector<Node> nodes) : nodes_(std::move(nodes)) {}

  /// Nothing is known of it.
  bool empty() const { return nodes_.empty(); }
  const std::vector<Node>& nodes() const { return nodes_; }

  /// corrected_world_from_world at an image, for what was seen near the body, which the filter had
  /// there.
  Eigen::Isometry3d At(std::int64_t stamp_ns, const Eigen::Vector3d& position_in_world) const;

  /// The nodes around an image.
  struct Between {
    std::size_t before = 0, after = 0;
    double share = 1;  ///< Of `after`.
  };
  Between Around(std::int64_t stamp_ns) const;

 private:
  std::vector<Node> nodes_;
};

/// What a trajectory is corrected by after loops were closed, and how well that is known.
class TrajectoryCorrection {
 public:
  TrajectoryCorrection() = default;
  /// @param covariances  Of the corrected pose of each node, order (x, y, z, yaw), since the
  ///                     trajectory's beginning.
  TrajectoryCorrection(std::vector<TrajectoryMoves::Node> nodes,
                       std::vector<Eigen::Matrix4d> covariances)
      : moves_(std::move(nodes)), covariances_(std::move(covariances)) {}

  /// Nothing was corrected: poses and covariances stay the filter's.
  bool empty() const { return moves_.empty(); }
  const TrajectoryMoves& moves() const { return moves_; }
  Eigen::Isometry3d At(std::int64_t stamp_ns, const Eigen::Vector3d& position_in_world) const {
    return moves_.At(stamp_ns, position_in_world);
  }

  /// The covariance of a corrected pose, order of PosePerturbation: heading and position of the
  /// body from the graph, tilt from the filter; what ties tilt to position is left out.
  PoseCovariance CovarianceAt(std::int64_t stamp_ns, const PoseCovariance& of_filter) const;

 private:
  TrajectoryMoves moves_;
  std::vector<Eigen::Matrix4d> covariances_;
};

}  // namespace plumbline
