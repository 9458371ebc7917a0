// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {

/// What an alignment may change. A locked direction stays exactly as it was.
enum class FreeMotion {
  kAzimuth,                ///< 1: the turn about up through the model's origin.
  kAzimuthAndHorizontal,   ///< 3: the turn and the two translations across up.
  kAzimuthAndTranslation,  ///< 4: the turn and all translation.
  kRigid,                  ///< 6
};

/// 1, 3, 4 or 6.
int DegreesOfFreedom(FreeMotion motion);
/// The reverse; 4 for any other number.
FreeMotion MotionWith(int degrees_of_freedom);

/// A point of the model and the point of the scan that it should meet.
struct PointPair {
  Eigen::Vector3d in_model{0, 0, 0};
  Eigen::Vector3d in_scan{0, 0, 0};
  Eigen::Vector3d normal_in_scan{0, 0, 0};  ///< Unit; for point-to-plane only.
  double weight = 1;
};

/// Order of the covariance: translation of the model's origin in the scan frame [m], then the
/// rotation vector applied on the left, in the scan frame [rad]. Locked directions are zero.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// A pose's standard deviations, split as people think of them. 0: that direction was locked.
struct PoseDeviations {
  double azimuth_rad = 0, horizontal_m = 0, height_m = 0;
  double position_m = 0;  ///< Horizontal and height together.
};
PoseDeviations DeviationsOf(const PoseCovariance& covariance, const Eigen::Vector3d& up_in_scan);

/// What lies between two poses of a model, split likewise.
struct PoseChange {
  double azimuth_rad = 0, horizontal_m = 0, height_m = 0, tilt_rad = 0;
};
PoseChange ChangeBetween(const Eigen::Isometry3d& scan_from_model,
                         const Eigen::Isometry3d& changed_scan_from_model,
                         const Eigen::Vector3d& up_in_scan);

/// A pose of a model that moves only as it is allowed to. The turn is kept as one angle, so that
/// the model's up axis keeps its angle to `up_in_scan` through any number of steps.
class ConstrainedPose {
 public:
  /// @param up_in_scan  Unit vector against gravity.
  ConstrainedPose(const Eigen::Isometry3d& start_scan_from_model, const Eigen::Vector3d& up_in_scan,
                  FreeMotion motion);

  const Eigen::Isometry3d& scan_from_model() const { return scan_from_model_; }
  FreeMotion motion() const { return motion_; }
  const Eigen::Vector3d& up_in_scan() const { return up_; }

  /// The pose of least sum of weight * squared distance over the pairs, in closed form
  /// (docs/algorithms/registration.md). Errors: kDegenerate, the pose unchanged, if the pairs
  /// do not show the free turn.
  Status FitPoints(std::span<const PointPair> pairs);

  /// One Gauss-Newton step on the free parameters for the distances along `normal_in_scan`. What
  /// the pairs do not show stays put. Returns the size of the step: metres and radians, the larger.
  double StepPlanes(std::span<const PointPair> pairs);

  /// Covariance if the distances along the normals are independent with standard deviation
  /// `sigma_m`. Directions that the pairs do not show get a variance of 1 (m^2 or rad^2).
  PoseCovariance PlaneCovariance(std::span<const PointPair> pairs, double sigma_m) const;

  /// How many times fewer independent measurements the pairs are than their number, because errors
  /// within patches of `patch_m` go together; at least 1. The variance of the pose by what the
  /// pulls of the patches differ by, over the same by single pairs (the design effect of cluster
  /// samples; docs/algorithms/registration.md).
  double DesignEffect(std::span<const PointPair> pairs, double patch_m) const;

  /// `covariance`, as of PlaneCovariance, widened in every direction to what the pose would move by
  /// if an eighth of the surface was left out, each in turn (the jackknife over octants about the
  /// middle of the pairs): where few patches decide, none of the residuals shows that one is wrong.
  PoseCovariance WidenedByParts(std::span<const PointPair> pairs,
                                const PoseCovariance& covariance) const;

 private:
  using Normal = Eigen::Matrix<double, 6, 6>;

  /// What a change of each free parameter does to (translation, rotation vector); the angle is
  /// last.
  Subspace FreeDirections() const;
  void SetAngle(double angle_rad);

  Eigen::Isometry3d scan_from_model_;
  Eigen::Matrix3d start_rotation_;
  Eigen::Vector3d up_;
  FreeMotion motion_;
  double angle_rad_ = 0;  ///< About up, from start_rotation_.
};

}  // namespace plumbline
