// SPDX-License-Identifier: Apache-2.0
#include "engine/registration/sequence_frames.h"

#include <cmath>

namespace plumbline {

Status CheckGravity(const GravityPair& gravity) {
  for (const Eigen::Vector3d& down : {gravity.in_world, gravity.in_scan}) {
    if (!(std::abs(down.norm() - 1) < 1e-6)) {
      return Error{ErrorCode::kInvalidInput, "gravity must be a unit vector in both frames"};
    }
  }
  return {};
}

Eigen::Matrix3d UprightTurn(const GravityPair& gravity) {
  return Eigen::Quaterniond::FromTwoVectors(gravity.in_world, gravity.in_scan).toRotationMatrix();
}

Eigen::Isometry3d UprightPlace(const GravityPair& gravity, double azimuth_rad,
                               const Eigen::Vector3d& translation) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(azimuth_rad, -gravity.in_scan) * UprightTurn(gravity);
  pose.translation() = translation;
  return pose;
}

}  // namespace plumbline
