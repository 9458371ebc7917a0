// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include <Eigen/Geometry>

#include "engine/dataset/ros_messages.h"
#include "engine/dataset/trajectory.h"

namespace plumbline {

/// The frames of a robot and how they lie over time, as TF tells it: each has one parent.
class TransformTree {
 public:
  /// @param fixed  Of /tf_static: it holds for all times.
  void Add(const RosTransform& transform, bool fixed);
  /// Sorts what was added; once, before anything is asked.
  void Finish();

  /// The topmost frame above this one; itself where it has no parent.
  std::string RootAbove(const std::string& frame) const;
  /// Whether anything between the two moves.
  bool Moves(const std::string& above, const std::string& frame) const;
  /// Nothing where `above` does not lie above `frame` or a transform is not known at this time: it
  /// lies between two that are at most half a second apart, or within 10 ms of one.
  std::optional<Eigen::Isometry3d> At(const std::string& above, const std::string& frame,
                                      std::int64_t stamp_ns) const;
  /// target_from_source of two frames that are rigidly joined.
  std::optional<Eigen::Isometry3d> Rigid(const std::string& target,
                                         const std::string& source) const;

 private:
  struct Edge {
    std::string parent;
    bool fixed = false;
    Trajectory parent_from_child;
  };
  std::optional<Eigen::Isometry3d> EdgeAt(const Edge& edge, std::int64_t stamp_ns) const;
  std::map<std::string, Edge> edges_;  ///< By the child.
};

}  // namespace plumbline
