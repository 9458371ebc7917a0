// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "engine/base/random.h"

namespace plumbline {

/// Any rotation alike, translation [m] of a standard Gaussian.
inline Eigen::Isometry3d RandomPose(Random& random) {
  Eigen::Vector4d q;
  for (double& value : q) value = random.Gaussian();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  for (double& value : pose.translation()) value = random.Gaussian();
  return pose;
}

}  // namespace plumbline
