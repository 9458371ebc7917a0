// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/covariance.h"

#include <algorithm>

namespace plumbline {

Eigen::Matrix4d CentreCovariance(const PoseCovariance& covariance,
                                 const Eigen::Matrix3d& world_from_object,
                                 const Eigen::Vector3d& centre_in_object,
                                 const Eigen::Vector3d& up_in_world) {
  const Eigen::Vector3d arm = world_from_object * centre_in_object;
  Eigen::Matrix<double, 4, 6> state_from_pose = Eigen::Matrix<double, 4, 6>::Zero();
  state_from_pose.topLeftCorner<3, 3>().setIdentity();
  for (int k = 0; k < 3; ++k)
    state_from_pose.block<3, 1>(0, 3 + k) = Eigen::Vector3d::Unit(k).cross(arm);
  state_from_pose.bottomRightCorner<1, 3>() = up_in_world.transpose();
  return state_from_pose * covariance * state_from_pose.transpose();
}

double HotellingFactor(int images) {
  constexpr double kMost = 3;
  const double nu = images - 1;
  return nu > 5 ? std::min(kMost, nu / (nu - 5)) : kMost;
}

}  // namespace plumbline
