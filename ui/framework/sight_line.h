// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace plumbline {

/// A line of sight in the frame that a 3-D view shows.
struct SightLine {
  Eigen::Vector3d eye{0, 0, 0}, direction{0, 0, -1};  ///< Unit direction.
};

/// How far along an axis from `origin` its nearest point to a line of sight is [m]; 0 where they
/// are nearly parallel.
/// @param axis  Unit vector.
inline double AlongAxisNear(const SightLine& sight, const Eigen::Vector3d& origin,
                            const Eigen::Vector3d& axis) {
  const Eigen::Vector3d to = origin - sight.eye;
  const double slope = axis.dot(sight.direction), across = 1 - slope * slope;
  if (across < 1e-3) return 0;
  return (slope * sight.direction.dot(to) - axis.dot(to)) / across;
}

}  // namespace plumbline
