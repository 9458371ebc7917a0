// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/trajectory_correction.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace plumbline {

Eigen::Isometry3d YawMove::AsIsometry() const {
  Eigen::Isometry3d move = Eigen::Isometry3d::Identity();
  move.linear() = Eigen::AngleAxisd(yaw_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  move.translation() = shift_m;
  return move;
}

YawMove MoveTo(const GraphPose& corrected, const Eigen::Vector3d& filter_position_in_world) {
  YawMove move{corrected.yaw_rad, {0, 0, 0}};
  move.shift_m =
      corrected.position_in_world - move.AsIsometry().linear() * filter_position_in_world;
  return move;
}

TrajectoryMoves::Between TrajectoryMoves::Around(std::int64_t stamp_ns) const {
  PLB_CHECK(!nodes_.empty());
  const auto found =
      std::lower_bound(nodes_.begin(), nodes_.end(), stamp_ns,
                       [](const Node& node, std::int64_t ns) { return node.stamp_ns < ns; });
  const auto after = static_cast<std::size_t>(found - nodes_.begin());
  if (after == 0) return {0, 0, 1};
  if (after == nodes_.size()) return {after - 1, after - 1, 1};
  const std::int64_t before_ns = nodes_[after - 1].stamp_ns;
  const double share = static_cast<double>(stamp_ns - before_ns) /
                       static_cast<double>(nodes_[after].stamp_ns - before_ns);
  return {after - 1, after, share};
}

Eigen::Isometry3d TrajectoryMoves::At(std::int64_t stamp_ns,
                                      const Eigen::Vector3d& position_in_world) const {
  const Between at = Around(stamp_ns);
  const Node &before = nodes_[at.before], &after = nodes_[at.after];
  GraphPose corrected;
  const double turn = std::remainder(after.corrected.yaw_rad - before.corrected.yaw_rad, 2 * M_PI);
  corrected.yaw_rad = before.corrected.yaw_rad + at.share * turn;
  const auto carried = [&](const Node& node) -> Eigen::Vector3d {
    return MoveTo(node.corrected, node.filter_position_in_world).AsIsometry() * position_in_world;
  };
  corrected.position_in_world = (1 - at.share) * carried(before) + at.share * carried(after);
  return MoveTo(corrected, position_in_world).AsIsometry();
}

PoseCovariance TrajectoryCorrection::CovarianceAt(std::int64_t stamp_ns,
                                                  const PoseCovariance& of_filter) const {
  const auto [before, after, share] = moves_.Around(stamp_ns);
  const Eigen::Matrix4d of_graph = (1 - share) * covariances_[before] + share * covariances_[after];
  PoseCovariance covariance = PoseCovariance::Zero();
  covariance.topLeftCorner<3, 3>() = of_graph.topLeftCorner<3, 3>();
  covariance.block<3, 1>(0, 5) = of_graph.block<3, 1>(0, 3);
  covariance.block<1, 3>(5, 0) = of_graph.block<1, 3>(3, 0);
  covariance(5, 5) = of_graph(3, 3);
  covariance.block<2, 2>(3, 3) = of_filter.block<2, 2>(3, 3);
  return covariance;
}

}  // namespace plumbline
