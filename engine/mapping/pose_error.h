// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
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

/// A view, and how much it counts.
struct WeightedView {
  UncertainView view;
  double weight = 1;
};

/// The covariance of a place relative to its reference camera, from errors that all views of it
/// share: poses that drift make a way too long or too short by one share all along, and with it the
/// world that is seen from it. No view contradicts that, so however many there are it stays.
/// The share's variance is that of the drift along the ways from the reference to the views; a size
/// that is known limits it.
/// @param size_std  Of the size of what stands there, as a share; 0: known exactly, as is then
/// where it stands.
Eigen::Matrix3d SharedError(const Eigen::Vector3d& point_in_world,
                            std::span<const WeightedView> views, const UncertainView& reference,
                            double size_std);

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
