// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/vio/imu_integration.h"

namespace plumbline {

/// First rows of the calibration in the filter's error. Rotation and translation of the camera:
/// R_bc = Exp(theta) R_bc^, p_bc = p_bc^ + d, along the axes of `body`; the lens by addition.
inline constexpr int kCamRotation = 15, kCamTranslation = 18, kTimeOffset = 21, kLens = 22,
                     kLensSize = 9, kCalibratedSize = 31;
inline constexpr int kPoseSize = 6, kPointSize = 3;
using CalibratedMatrix = Eigen::Matrix<double, kCalibratedSize, kCalibratedSize>;

/// DistortedCamera::Intrinsics, then the time from the first row of an image to the last [s].
using LensVector = Eigen::Matrix<double, kLensSize, 1>;
inline constexpr int kReadOut = 8;  ///< Within a LensVector.

/// The body at the time of an image. Its error is (phi, xi_p) as of an InertialState.
struct PoseClone {
  std::int64_t id = 0;        ///< Rises by one with each clone.
  std::int64_t stamp_ns = 0;  ///< Of the image, on the camera's clock.
  Eigen::Isometry3d world_from_body = Eigen::Isometry3d::Identity();
  int row = 0;  ///< First row in the filter's error.
  /// What the picture moved by since the image before: a moving picture is blurred [px].
  double flow_px = 0;
  /// How the pose moves with time: its (phi, xi_p) per second.
  Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
};

/// A point in the state: in the camera of its anchor, (X/Z, Y/Z, 1/Z); its error is that of
/// MovedPoint().
struct StatePoint {
  std::int64_t track = 0;
  std::int64_t anchor = 0;  ///< Id of a clone.
  Eigen::Vector3d bearing_and_inverse_depth{0, 0, 1};
  int row = 0;
  int age = 0;       ///< Images that it was seen in.
  int rejected = 0;  ///< Measurements in a row that the gate turned away.
};

/// Rows of the error that a Jacobian speaks of.
struct RowRange {
  int begin = 0, size = 0;
};

/// What a measurement is off by.
enum class NoiseOf { kImages, kRest };

/// The filter's state and the covariance of its error, on their manifold. The error is that of
/// the InertialState, then calibration, then clones and points in any order.
class FilterState {
 public:
  FilterState() = default;
  FilterState(const InertialState& inertial, const Eigen::Isometry3d& body_from_cam,
              double time_offset_s, const LensVector& lens, const CalibratedMatrix& covariance);

  const InertialState& inertial() const { return inertial_; }
  const Eigen::Isometry3d& body_from_cam() const { return body_from_cam_; }
  double time_offset_s() const { return time_offset_s_; }
  const LensVector& lens() const { return lens_; }
  const std::vector<PoseClone>& clones() const { return clones_; }
  std::vector<StatePoint>& points() { return points_; }
  const std::vector<StatePoint>& points() const { return points_; }
  const PoseClone* FindClone(std::int64_t id) const;
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  /// The part of the covariance that errors of images cause, by the gains that were applied: all
  /// but what the start, the readings of the IMU and rest leave uncertain.
  const Eigen::MatrixXd& covariance_by_images() const { return by_images_; }
  int size() const { return static_cast<int>(covariance_.rows()); }

  /// Carries the inertial part forward. `integration` started from inertial().
  void Propagate(const Integration& integration);

  /// Appends the present pose, taken at an image of the camera's clock. A true offset that is
  /// larger means that the image was taken later: the clone's error has a part by the offset.
  /// @param angular_velocity_in_body  At that time, without bias [rad/s].
  /// @param flow_px  PoseClone::flow_px.
  /// @param jitter_rad, jitter_m  What the image as a whole is off by, each axis: independent from
  ///        image to image, so that many points do not average it out.
  const PoseClone& AddClone(std::int64_t stamp_ns, const Eigen::Vector3d& angular_velocity_in_body,
                            double flow_px, double jitter_rad, double jitter_m);

  /// One update with residual = jacobian * error + noise of unit variance. The columns of
  /// `jacobian` are those of `rows`, in their order.
  /// @return false, without a change, where the innovation's covariance is not positive.
  bool Update(const Eigen::MatrixXd& jacobian, std::span<const RowRange> rows,
              const Eigen::VectorXd& residual, NoiseOf noise);

  /// jacobian * covariance * jacobian' of these rows alone.
  Eigen::MatrixXd Projected(const Eigen::MatrixXd& jacobian, std::span<const RowRange> rows) const;

  /// Appends a point that upper-triangular `by_point` * point error = noise of unit variance +
  /// residual - by_state * error determines; `residual` corrects the point's first value.
  void AddPoint(const StatePoint& point, const Eigen::MatrixXd& by_state,
                std::span<const RowRange> rows, const Eigen::Matrix3d& by_point,
                const Eigen::Vector3d& residual);

  /// Replaces the chart of a point: its new error is `jacobian` times the error of `rows`.
  void ChangePoint(StatePoint& point, std::int64_t anchor, const Eigen::Vector3d& value,
                   const Eigen::MatrixXd& jacobian, std::span<const RowRange> rows);

  void RemoveClone(std::int64_t id);
  void RemovePoint(std::int64_t track);

  /// The covariance of InertialState and calibration where errors of images last `inflation` times
  /// as long as the gains took them to: P + (inflation - 1) * covariance_by_images().
  CalibratedMatrix InflatedCovariance(double inflation) const;

  /// By it the present pose's error as files and mapper have it: translation and rotation vector
  /// along `world`, the rotation not moving the body (sensor/pose_estimate.h).
  Eigen::Matrix<double, 6, 6> PoseCovariance(double inflation) const;

  /// Adds to the covariance of points, which are not the ones that images show.
  void Creep(RowRange rows, double variance);

  bool finite() const;

 private:
  void Retract(const Eigen::VectorXd& error);
  void RemoveRows(RowRange rows);

  InertialState inertial_;
  Eigen::Isometry3d body_from_cam_ = Eigen::Isometry3d::Identity();
  double time_offset_s_ = 0;
  LensVector lens_ = LensVector::Zero();
  std::vector<PoseClone> clones_;
  std::vector<StatePoint> points_;
  Eigen::MatrixXd covariance_, by_images_;
  std::int64_t next_clone_ = 0;
};

/// The pose with an error (phi, xi_p) applied.
Eigen::Isometry3d Moved(const Eigen::Isometry3d& world_from_body,
                        const Eigen::Matrix<double, 6, 1>& error);

}  // namespace plumbline
