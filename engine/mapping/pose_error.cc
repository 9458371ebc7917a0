// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/pose_error.h"

#include <cmath>

#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {
namespace {

// The search along normals has 2.5 px: with one more, 2.7.
constexpr double kNegligible_px = 1, kFocal_px = 500;
constexpr double kStep = 1e-5;  ///< Of the numerical derivative [m, rad].
constexpr double kNear_m = 0.1;

}  // namespace

PoseCovariance RelativeCovariance(const PoseUncertainty& view, const PoseUncertainty& reference) {
  PoseCovariance drift = view.drift - reference.drift;
  // Seen before the reference was: the later of the two has drifted further.
  if (drift.trace() < 0) drift = -drift;
  return drift + view.own;
}

std::vector<ImageShift> ImageShiftsOf(const PoseCovariance& relative,
                                      const Eigen::Isometry3d& world_from_cam,
                                      const PinholeCamera& camera,
                                      const Eigen::Vector3d& point_in_world) {
  if (relative.isZero(0)) return {};
  const auto pixel = [&](const PosePerturbation& error) -> Eigen::Vector2d {
    return camera.Project(Perturbed(world_from_cam, error).inverse() * point_in_world);
  };
  if ((world_from_cam.inverse() * point_in_world).z() < kNear_m) return {};
  Eigen::Matrix<double, 2, 6> jacobian;
  for (int k = 0; k < 6; ++k) {
    const PosePerturbation step = kStep * PosePerturbation::Unit(k);
    jacobian.col(k) = (pixel(step) - pixel(-step)) / (2 * kStep);
  }
  const Eigen::Matrix2d in_image = jacobian * relative * jacobian.transpose();
  const SymmetricEigen axes = EigenOf(in_image);
  // A difference of covariances may be negative along a direction: then nothing is added there.
  const Eigen::Vector2d deviations = axes.values.cwiseMax(0).cwiseSqrt();
  if (deviations.maxCoeff() < kNegligible_px * camera.fx / kFocal_px) return {};
  std::vector<ImageShift> shifts = {{0, 0, 1.0 / 3}};
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d reach = std::sqrt(3.0) * deviations[k] * axes.vectors.col(k);
    shifts.push_back({reach.x(), reach.y(), 1.0 / 6});
    shifts.push_back({-reach.x(), -reach.y(), 1.0 / 6});
  }
  return shifts;
}

}  // namespace plumbline
