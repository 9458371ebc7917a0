// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/ids.h"

namespace plumbline {

using PoseId = StrongId<struct PoseIdTag>;  ///< Names the pose of one image, across corrections.

/// Error of a pose, in the order of all pose covariances: (x, y, z, rx, ry, rz), translation [m]
/// and rotation vector [rad], both along the axes of `world`.
using PosePerturbation = Eigen::Matrix<double, 6, 1>;
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// The pose with an error: translation + (x, y, z); Exp(rx, ry, rz) * rotation. The rotation's
/// error is applied on the side of the world and does not move the origin of `cam`.
inline Eigen::Isometry3d Perturbed(const Eigen::Isometry3d& world_from_cam,
                                   const PosePerturbation& error) {
  Eigen::Isometry3d result = world_from_cam;
  const double angle = error.tail<3>().norm();
  if (angle > 0) {
    const Eigen::Vector3d axis = error.tail<3>() / angle;
    result.linear() = Eigen::AngleAxisd(angle, axis) * world_from_cam.linear();
  }
  result.translation() += error.head<3>();
  return result;
}

/// The error with Perturbed(from, error) = to.
inline PosePerturbation PerturbationBetween(const Eigen::Isometry3d& from,
                                            const Eigen::Isometry3d& to) {
  const Eigen::AngleAxisd turn(Eigen::Quaterniond(to.linear() * from.linear().transpose()));
  PosePerturbation error;
  error << to.translation() - from.translation(), turn.angle() * turn.axis();
  return error;
}

/// Where the camera was at one time, as somebody estimates it. An estimate with the id of an
/// earlier one and a higher epoch corrects it.
struct PoseEstimate {
  PoseId id;
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();  ///< Of the first camera.
  PoseCovariance covariance = PoseCovariance::Zero();  ///< Zero: given, not estimated.
  int epoch = 0;                                       ///< Rises whenever the past was corrected.
};

/// How the errors of the pose of one view and of the reference views that it names belong together.
/// What a mapper needs is the error of one view relative to another: two covariances on their own
/// would count the common part twice.
struct JointPoseCovariance {
  std::vector<PoseId> references;
  /// Square, 6 rows for the view and 6 for each reference, in that order, each in the order of
  /// PosePerturbation. Empty: all these poses are exact.
  Eigen::MatrixXd covariance;
};

}  // namespace plumbline
