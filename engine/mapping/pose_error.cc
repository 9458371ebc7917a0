// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/pose_error.h"

#include <cmath>

#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {
namespace {

// The search along normals has 2.5 px: with one more, 2.7.
constexpr double kNegligible_px = 1, kFocal_px = 500;
constexpr double kStep_m = 1e-5;  ///< Of the numerical derivative.
constexpr double kNear_m = 0.1;
constexpr double kLeastWay_m = 0.01;

PoseCovariance AtPoint(const Eigen::Vector3d& point_in_world,
                       const Eigen::Isometry3d& world_from_cam, const PoseCovariance& covariance) {
  return MovedBy(point_in_world - world_from_cam.translation(), covariance);
}

}  // namespace

PoseCovariance DriftAt(const Eigen::Vector3d& point_in_world, const UncertainView& view,
                       const UncertainView& reference) {
  return AtPoint(point_in_world, view.world_from_cam, view.uncertainty.drift) -
         AtPoint(point_in_world, reference.world_from_cam, reference.uncertainty.drift);
}

Eigen::Matrix3d SharedError(const Eigen::Vector3d& point_in_world,
                            std::span<const WeightedView> views, const UncertainView& reference,
                            double size_std) {
  const Eigen::Vector3d origin = reference.world_from_cam.translation();
  double drift = 0, way = 0;
  for (const auto& [view, weight] : views) {
    const Eigen::Vector3d to = view.world_from_cam.translation();
    const Eigen::Vector3d moved = to - origin;
    const double length = moved.norm();
    if (length < kLeastWay_m) continue;
    const Eigen::Matrix3d error = DriftAt(to, view, reference).topLeftCorner<3, 3>();
    drift += weight * std::abs(moved.dot(error * moved)) / (length * length);
    way += weight * length * length;
  }
  if (drift <= 0 || size_std <= 0) return Eigen::Matrix3d::Zero();
  const double share = 1 / (way / drift + 1 / (size_std * size_std));
  const Eigen::Vector3d ray = point_in_world - origin;
  return share * ray * ray.transpose();
}

std::vector<ImageShift> ImageShiftsOf(const Eigen::Vector3d& point_in_world,
                                      const UncertainView& view, const UncertainView& reference,
                                      const PinholeCamera& camera) {
  const PoseUncertainty& own = view.uncertainty;
  if (own.drift.isZero(0) && reference.uncertainty.drift.isZero(0) && own.own.isZero(0)) return {};
  const Eigen::Isometry3d cam_from_world = view.world_from_cam.inverse();
  if ((cam_from_world * point_in_world).z() < kNear_m) return {};
  Eigen::Matrix<double, 2, 3> jacobian;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(k);
    jacobian.col(k) = (camera.Project(cam_from_world * (point_in_world + step)) -
                       camera.Project(cam_from_world * (point_in_world - step))) /
                      (2 * kStep_m);
  }
  const auto in_image = [&](const PoseCovariance& at_point) -> Eigen::Matrix2d {
    return jacobian * at_point.topLeftCorner<3, 3>() * jacobian.transpose();
  };
  // Grown or shrunk, an error that two views do not share.
  const SymmetricEigen drift = EigenOf(in_image(DriftAt(point_in_world, view, reference)));
  const SymmetricEigen axes =
      EigenOf(drift.vectors * drift.values.cwiseAbs().asDiagonal() * drift.vectors.transpose() +
              in_image(AtPoint(point_in_world, view.world_from_cam, own.own)));
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
