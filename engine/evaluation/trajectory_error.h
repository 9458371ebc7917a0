// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/options.h"

namespace plumbline {

/// A pose of a trajectory that is judged, of the camera or of the body.
struct TimedPose {
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_sensor = Eigen::Isometry3d::Identity();
  /// In the order of PosePerturbation (sensor/pose_estimate.h); nothing where none is known.
  std::optional<Eigen::Matrix<double, 6, 6>> covariance;
};

enum class TrajectoryAlignment { kNone, kYaw, kSe3, kSim3 };
template <>
struct EnumNames<TrajectoryAlignment> {
  static constexpr std::string_view names[] = {"none", "yaw", "se3", "sim3"};
};

/// The error of the motion between two times or places.
struct RelativeError {
  double span = 0;           ///< [s], or [m] along the reference.
  int pairs = 0;             ///< 0: the trajectory is too short; the errors are 0.
  double translation_m = 0;  ///< Root mean square.
  double translation_median_m = 0;
  double rotation_rad = 0;  ///< Root mean square.
};

struct TrajectoryErrors {
  int matched = 0;    ///< Poses with a reference.
  double path_m = 0;  ///< Length of the reference over the matched poses.
  Eigen::Matrix4d reference_from_estimate = Eigen::Matrix4d::Identity();  ///< With the scale.
  double ate_m = 0, ate_max_m = 0;  ///< Root mean square and largest distance, aligned.
  double ate_rad = 0;               ///< Root mean square angle, aligned.
  double tilt_rad = 0;              ///< Root mean square angle between the directions of down.
  double scale = 1;                 ///< By which the estimate has to grow (similarity alignment).
  std::vector<RelativeError> by_time, by_length;
  /// Mean of e' P^-1 e over the poses with a covariance; 6 if honest. The first pose is the gauge:
  /// the reference is moved onto it in heading and position.
  std::optional<double> nees;
  int nees_poses = 0;
};

struct TrajectoryErrorOptions {
  TrajectoryAlignment align = TrajectoryAlignment::kYaw;
  std::vector<double> spans_s = {1, 5};
  std::vector<double> lengths_m = {1, 5, 10, 50};
};

/// Compares a trajectory with a reference whose z axis points up, after an alignment that
/// minimises the mean squared distance. docs/algorithms/vio.md has the formulas. A pose is matched
/// with the reference at its stamp, interpolated between two poses at most 0.2 s apart.
/// @param estimate, reference  By rising stamp.
/// Errors: kDegenerate for fewer than 3 matched poses.
Result<TrajectoryErrors> CompareTrajectories(std::span<const TimedPose> estimate,
                                             std::span<const TimedPose> reference,
                                             const TrajectoryErrorOptions& options);

}  // namespace plumbline
