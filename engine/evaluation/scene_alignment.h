// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "engine/geometry/closest_triangle.h"

namespace plumbline {

/// The turn about `up` and the translation that bring `estimate` closest to `truth` (pairs i, i;
/// least squares, closed form). `up` is the same direction in both frames. Where the pairs do not
/// show a turn (one pair, or all above one another) there is none; without pairs the identity.
Eigen::Isometry3d FitYawAndTranslation(const std::vector<Eigen::Vector3d>& estimate,
                                       const std::vector<Eigen::Vector3d>& truth,
                                       const Eigen::Vector3d& up);

/// Of the points drawn on a map, how many an ICP uses.
inline constexpr std::size_t kIcpSamples = 20'000;

struct IcpOptions {
  double max_distance_m = 0.5;  ///< Pairs farther apart do not count.
  int max_iterations = 100;
};

/// Moves points onto a surface by iterated closest points (point to plane), beginning where they
/// are. With `up` only the turn about it and the translation are free.
Eigen::Isometry3d AlignToSurface(const std::vector<Eigen::Vector3d>& points,
                                 const ClosestTriangleSearch& surface,
                                 const std::optional<Eigen::Vector3d>& up,
                                 const IcpOptions& options = {});

}  // namespace plumbline
