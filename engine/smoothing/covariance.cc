// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/covariance.h"

#include "engine/geometry/symmetric_matrix.h"

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

Eigen::Matrix4d LargerOf(const Eigen::Matrix4d& a, const Eigen::Matrix4d& b) {
  const SymmetricEigen of_a = EigenOf(a);
  const Eigen::Matrix4d axes = of_a.vectors;
  const Eigen::Vector4d root = of_a.values.cwiseMax(1e-18).cwiseSqrt();
  const Eigen::Matrix4d whiten = root.cwiseInverse().asDiagonal() * axes.transpose();
  const Eigen::Matrix4d colour = axes * root.asDiagonal();
  const SymmetricEigen of_b = EigenOf(Eigen::MatrixXd(whiten * b * whiten.transpose()));
  const Eigen::Matrix4d both = colour * Eigen::Matrix4d(of_b.vectors);
  const Eigen::Vector4d variances = of_b.values.cwiseMax(1.0);
  return both * variances.asDiagonal() * both.transpose();
}

}  // namespace plumbline
