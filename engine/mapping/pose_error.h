// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// The pose of a view, and how uncertain it is.
struct UncertainView {
  const Eigen::Isometry3d& world_from_cam;
  const PoseUncertainty& uncertainty;
};

/// By how much the drift of poses moves a point between two views: the difference of the
/// covariances of both, each carried to the point. What is common to both, as a tilt of the whole
/// world, moves the point along and drops out. Where it is negative, the later view knows better,
/// and has been corrected by so much.
PoseCovariance DriftAt(const Eigen::Vector3d& point_in_world, const UncertainView& view,
                       const UncertainView& reference);

/// Where the image of a point may be, as the pose of its view errs relative to that of an object's
/// reference view: five sigma points of a normal distribution in the image (centre, and sqrt(3)
/// deviations to each side along both axes of its ellipse), which give moments up to the third
/// exactly. An error of a pose moves all of a small object alike, so it is one shift and no noise
/// of single edges. Empty where that is too small to matter (a pixel at a focal length of 500), or
/// the point is behind the camera.
std::vector<ImageShift> ImageShiftsOf(const Eigen::Vector3d& point_in_world,
                                      const UncertainView& view, const UncertainView& reference,
                                      const PinholeCamera& camera);

}  // namespace plumbline
