// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/pose_error.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "engine/base/check.h"

namespace plumbline {
namespace {

/// Exact for small angles too, where acos of a dot product is not.
double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

}  // namespace

PoseError ComparePoses(const Eigen::Isometry3d& world_from_estimate,
                       const Eigen::Isometry3d& world_from_truth, const Symmetry& symmetry,
                       const UprightFrame& upright) {
  PLB_CHECK(symmetry.order >= 0) << symmetry.order;
  const Eigen::Matrix3d estimate = world_from_estimate.linear();
  const Eigen::Matrix3d truth = world_from_truth.linear();
  const Eigen::Vector3d difference =
      world_from_estimate.translation() - world_from_truth.translation();
  PoseError error;
  error.translation_m = difference.norm();
  error.height_m = difference.dot(upright.up_in_world());
  const Eigen::Vector3d axis = symmetry.axis.normalized();
  if (symmetry.order == 0) {
    error.tilt_rad = AngleBetween(estimate * axis, truth * axis);
    error.rotation_rad = error.tilt_rad;
    return error;
  }
  error.rotation_rad = std::numeric_limits<double>::infinity();
  for (int k = 0; k < symmetry.order; ++k) {
    const Eigen::Matrix3d equivalent =
        truth *
        Eigen::AngleAxisd(2 * std::numbers::pi * k / symmetry.order, axis).toRotationMatrix();
    const double angle =
        Eigen::Quaterniond(estimate).angularDistance(Eigen::Quaterniond(equivalent));
    if (angle >= error.rotation_rad) continue;
    error.rotation_rad = angle;
    error.azimuth_rad = WrapAngle(upright.Azimuth(estimate) - upright.Azimuth(equivalent));
    error.tilt_rad = AngleBetween(estimate.col(2), equivalent.col(2));
  }
  return error;
}

}  // namespace plumbline
