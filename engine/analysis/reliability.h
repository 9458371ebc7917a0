// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "engine/snapshot/object_history.h"
#include "engine/snapshot/run_history.h"

namespace plumbline {

/// Counts confirmed objects in the frames in which they were updated and lie within
/// kReliabilityReach_m of a true object of their category.
/// @param only  This object alone; not valid: all.
Reliability ReliabilityOf(const RunHistory& history, ObjectId only = {});
inline constexpr float kReliabilityReach_m = 0.5f;

/// Share of a Gaussian belief that is likelier than the truth, in [0, 1]: the truth lies in the 95
/// % region if it is at most 0.95. Ground truth is taken to be exact to 3 mm and half a degree.
/// @param offset      Truth minus mean: x, y, z [m], azimuth [rad].
/// @param covariance  Of the belief, in the same order.
/// @param round       The azimuth says nothing.
double CredibleLevel(const Eigen::Vector4d& offset, const Eigen::Matrix4d& covariance, bool round);

}  // namespace plumbline
