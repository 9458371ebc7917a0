// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/drift.h"

#include <Eigen/Eigenvalues>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

constexpr double kStepStd_m = 0.002, kStepStdDeg = 0.02;  ///< Of an edge, at least.

}  // namespace

Eigen::Matrix4d DriftBetween(const Eigen::Vector3d& from_in_world, const PoseCovariance& from,
                             const Eigen::Vector3d& to_in_world, const PoseCovariance& to,
                             double factor) {
  // Errors of the one at the place of the other: what is common to both drops out.
  const Eigen::Matrix4d growth = InFour(to - MovedBy(to_in_world - from_in_world, from));
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> parts((growth + growth.transpose()) / 2);
  const Eigen::Vector4d positive = parts.eigenvalues().cwiseMax(0) * factor * factor;
  Eigen::Matrix4d drift =
      parts.eigenvectors() * positive.asDiagonal() * parts.eigenvectors().transpose();
  const double turn = kStepStdDeg * kRadPerDeg;
  drift.diagonal() += Eigen::Vector4d(kStepStd_m * kStepStd_m, kStepStd_m * kStepStd_m,
                                      kStepStd_m * kStepStd_m, turn * turn);
  return drift;
}

Eigen::Matrix4d HandedOn(const Eigen::Vector3d& first_in_world, const PoseCovariance& first,
                         const Eigen::Vector3d& later_in_world) {
  PoseCovariance level = first;
  level.middleRows<2>(3).setZero();
  level.middleCols<2>(3).setZero();
  return InFour(MovedBy(later_in_world - first_in_world, level));
}

}  // namespace plumbline
