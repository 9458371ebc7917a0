// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "engine/registration/constrained_fit.h"

namespace plumbline {

/// Covariance of (x, y, z of the model's centre in world [m], azimuth [rad]) from that of its
/// pose.
Eigen::Matrix4d CentreCovariance(const PoseCovariance& covariance,
                                 const Eigen::Matrix3d& world_from_object,
                                 const Eigen::Vector3d& centre_in_object,
                                 const Eigen::Vector3d& up_in_world);

/// The least covariance that is nowhere smaller than either: in the directions in which both are
/// diagonal, the larger variance. Both positive definite.
Eigen::Matrix4d LargerOf(const Eigen::Matrix4d& a, const Eigen::Matrix4d& b);

}  // namespace plumbline
