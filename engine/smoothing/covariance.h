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

/// By what a covariance of four parameters that was estimated from the scatter of `images` images
/// has to be enlarged, so that the squared error normalised by it has the mean 4 that an honest one
/// has: it follows Hotelling's T^2 with nu = images - 1 degrees of freedom, whose mean is
/// 4 nu / (nu - 5). At most 3, where images are too few for a mean.
double HotellingFactor(int images);

}  // namespace plumbline
