// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace plumbline {

/// A key frame's correction in the four directions that a visual-inertial filter drifts in.
struct GraphPose {
  double yaw_rad = 0;  ///< By which the filter's attitude is turned about up.
  Eigen::Vector3d position_in_world{0, 0, 0};
};

/// What is known of two poses: Rz(-yaw_from) (p_to - p_from) = step and yaw_to - yaw_from = yaw,
/// with an error of this covariance in the order (x, y, z, yaw).
struct GraphEdge {
  int from = 0, to = 0;
  Eigen::Vector3d step{0, 0, 0};  ///< In the filter's axes at `from` [m].
  double yaw_rad = 0;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Identity();
  /// It may be false: what it weighs is chosen with the poses.
  bool doubtful = false;
};

/// Poses in yaw and position, tied by relative measurements; the first stays where it is
/// (docs/algorithms/vio.md, "Coming back"). A doubtful edge costs `doubt` x / (doubt + x) of its
/// squared error x, the best that a switch for it could do (Suenderhauf and Protzel, IROS 2012,
/// with the switch in closed form). Single-threaded, deterministic.
class PoseGraph {
 public:
  /// @param doubt  Squared error (of 4 degrees of freedom) from which a doubtful edge counts
  /// little.
  explicit PoseGraph(double doubt) : doubt_(doubt) {}

  void AddPose(const GraphPose& pose) { poses_.push_back(pose); }
  /// Between poses that were added; the covariance is positive definite.
  void AddEdge(const GraphEdge& edge);
  /// Takes poses out that two certain edges alone tie to others: these become one.
  /// @param unwanted  For each pose. The first, the last and those of other edges stay.
  /// @return for each pose its number now; -1 for those that are gone.
  std::vector<int> TakeOut(const std::vector<bool>& unwanted);
  /// Takes the edge that was added last away again.
  void RemoveLastEdge();

  /// Moves all poses but the first to the least cost (Ceres, Levenberg-Marquardt). Doubt sets in
  /// step by step, so that a true edge far off is not given up before poses have moved.
  void Optimise();

  std::span<const GraphPose> poses() const { return poses_; }
  std::span<const GraphEdge> edges() const { return edges_; }

  /// Error of an edge in its own coordinates, by the poses less as measured, order (x, y, z,
  /// yaw).
  Eigen::Vector4d ErrorOf(const GraphEdge& edge) const;
  /// Between 0 (given up) and 1 (taken as it is): the switch of a doubtful edge.
  double TrustIn(const GraphEdge& edge) const;

  /// Covariance of what an edge between the two would measure, as the graph knows it. They differ.
  Eigen::Matrix4d RelativeCovariance(int from, int to) const;
  /// Covariance of each pose against the first, in the order (x, y, z, yaw).
  std::vector<Eigen::Matrix4d> Marginals() const;
  /// About how many multiplications it takes to factor its information: more, the more loops meet.
  double Work() const;

 private:
  double doubt_;
  std::vector<GraphPose> poses_;
  std::vector<GraphEdge> edges_;
};

}  // namespace plumbline
