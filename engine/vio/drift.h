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

/// What the first pose of a chain hands on to a later one: its heading turns and its place shifts
/// all that hangs on it. Its tilt does neither, since every step of a filter is level by the tilt
/// of its own time, and errs by what that errs.
Eigen::Matrix4d HandedOn(const Eigen::Vector3d& first_in_world, const PoseCovariance& first,
                         const Eigen::Vector3d& later_in_world);

}  // namespace plumbline
