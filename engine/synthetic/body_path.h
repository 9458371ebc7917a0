// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plumbline {

/// The motion of a body as a curve whose acceleration and angular acceleration are continuous: a
/// uniform cubic B-spline over poses, of rotations the cumulative one (Kim, Kim and Shin, SIGGRAPH
/// 1995). It passes near its knots (within some 0.01 mm at a walk), so images that shall agree with
/// an IMU are to be taken from the curve.
class BodyPath {
 public:
  /// @param room_from_body  Asked at knots 10 ms apart, from 1 s before 0 to 1 s after `seconds`.
  BodyPath(const std::function<Eigen::Isometry3d(double t_s)>& room_from_body, double seconds);

  /// `t_s` from -0.9 to seconds + 0.9; beyond, that of the end.
  Eigen::Isometry3d RoomFromBody(double t_s) const;
  Eigen::Vector3d VelocityInRoom(double t_s) const;         ///< [m/s]
  Eigen::Vector3d AccelerationInRoom(double t_s) const;     ///< [m/s^2]
  Eigen::Vector3d AngularVelocityInBody(double t_s) const;  ///< [rad/s]

 private:
  struct Place {
    std::size_t first;  ///< Of four knots.
    double share;       ///< Of the way from the second to the third.
  };
  Place PlaceAt(double t_s) const;
  /// Positions of four knots, weighted.
  Eigen::Vector3d Weighted(std::size_t first, const Eigen::Vector4d& weights) const;

  std::vector<Eigen::Isometry3d> knots_;
};

/// Time of a walk that stands still until `rest_s` and then takes a second to come to its pace,
/// with continuous acceleration.
double TimeAfterRest(double t_s, double rest_s);

}  // namespace plumbline
