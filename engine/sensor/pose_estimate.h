// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

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

/// The covariance of the pose of something that sits at the end of an arm: what turns the arm moves
/// its end.
/// @param arm_in_world  From the origin of the first to that of the second [m].
inline PoseCovariance MovedBy(const Eigen::Vector3d& arm_in_world,
                              const PoseCovariance& covariance) {
  PoseCovariance move = PoseCovariance::Identity();
  move.block<3, 3>(0, 3) << 0, arm_in_world.z(), -arm_in_world.y(), -arm_in_world.z(), 0,
      arm_in_world.x(), arm_in_world.y(), -arm_in_world.x(), 0;
  return move * covariance * move.transpose();
}

/// Of the rows and columns (x, y, z, turn about z): what is left where gravity is known.
inline Eigen::Matrix4d InFour(const PoseCovariance& covariance) {
  constexpr int kRows[] = {0, 1, 2, 5};
  Eigen::Matrix4d four;
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) four(r, c) = covariance(kRows[r], kRows[c]);
  }
  return four;
}

/// How uncertain a pose is. What a mapper needs is how one view errs relative to another: two whole
/// covariances would count the common part twice.
struct PoseUncertainty {
  /// Of the error that later poses go on from, as a filter's do: it only grows, and the relative
  /// error of two poses has the difference of theirs. Zero: given, not estimated.
  PoseCovariance drift = PoseCovariance::Zero();
  /// Of the error that this pose shares with no other, as poses that were found one by one have.
  PoseCovariance own = PoseCovariance::Zero();
};

/// Where the camera was at one time, as somebody estimates it. An estimate with the id of an
/// earlier one and a higher epoch corrects it.
struct PoseEstimate {
  PoseId id;
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();  ///< Of the first camera.
  PoseUncertainty uncertainty;
  int epoch = 0;  ///< Rises whenever the past was corrected.
};

}  // namespace plumbline
