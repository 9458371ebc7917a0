// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include <Eigen/Core>

#include "engine/vio/own_pose_options.h"
#include "engine/vio/own_pose_report.h"

namespace plumbline {

/// Finds the floor among points of a world whose z is up: the lowest height at which many of them
/// lie, with next to nothing below. Points come and the answer changes with them; nothing is
/// answered before enough of them agree. Deterministic.
class FloorFinder {
 public:
  explicit FloorFinder(const OwnPoseOptions& options) : options_(options) {}

  /// A point that was triangulated at an image.
  /// @param image  Number of the image: points of one image err together.
  void Add(const Eigen::Vector3d& point_in_world, int image);
  /// Points of an earlier world, before the filter began anew, say nothing any more.
  void Clear() { points_.clear(); }

  /// @param camera_height_m  Along up, from the origin of `world`: the floor is well below it.
  std::optional<FloorReport> Find(double camera_height_m) const;

 private:
  struct Point {
    double height_m = 0;
    int image = 0;
    double x = 0, y = 0;
  };
  OwnPoseOptions options_;
  std::deque<Point> points_;  ///< In the order of time; the oldest go, as poses drift.
};

}  // namespace plumbline
