// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// Covariance of a view's pose relative to that of an object's reference view. What both share, a
/// drift up to then, moves the object along and is no error between them.
PoseCovariance RelativeCovariance(const PoseUncertainty& view, const PoseUncertainty& reference);

/// Where the image of a point may be, as the pose of its view errs: five sigma points of a normal
/// distribution in the image (centre, and sqrt(3) deviations to each side along both axes of its
/// ellipse), which give moments up to the third exactly. An error of a pose moves all of a small
/// object alike, so it is one shift and no noise of single edges. Empty where that is too small to
/// matter (a pixel at a focal length of 500), or the point is behind the camera.
std::vector<ImageShift> ImageShiftsOf(const PoseCovariance& relative,
                                      const Eigen::Isometry3d& world_from_cam,
                                      const PinholeCamera& camera,
                                      const Eigen::Vector3d& point_in_world);

}  // namespace plumbline
