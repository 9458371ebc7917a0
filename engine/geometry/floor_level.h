// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>

#include "engine/geometry/gravity.h"

namespace plumbline {

/// A level beside the floor that things stand on: a platform, a step, a lower part of the room.
struct FloorLevel {
  double height_m = 0;  ///< Above the floor; negative: below it.
  double std_m = 0;     ///< Of that height.
  /// Corners of the place that it takes, in order; of each the horizontal position counts. Empty:
  /// it may be anywhere.
  std::vector<Eigen::Vector3d> outline_in_world;
};

/// Whether a point lies over or under the outline of a level, which has one.
bool Holds(const FloorLevel& level, const Eigen::Vector3d& point_in_world,
           const UprightFrame& upright);

}  // namespace plumbline
