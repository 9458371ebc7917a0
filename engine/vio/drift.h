// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// What the relative pose of two moments drifted by, as a filter has it: covariance of an edge
/// between them (GraphEdge), the growth of the filter's covariance along what it cannot observe,
/// never less than a little.
/// @param factor  On standard deviations.
Eigen::Matrix4d DriftBetween(const Eigen::Vector3d& from_in_world, const PoseCovariance& from,
                             const Eigen::Vector3d& to_in_world, const PoseCovariance& to,
                             double factor);

/// Covariance (x, y, z [m], heading [rad], axes of world) that the error of the first pose of a
/// chain adds to a later one: the error of its heading turns the chain about it, that of its place
/// shifts the chain. That of its tilt does neither: each step of a filter is level by the tilt of
/// its own time.
Eigen::Matrix4d HandedOn(const Eigen::Vector3d& first_in_world, const PoseCovariance& first,
                         const Eigen::Vector3d& later_in_world);

}  // namespace plumbline
