// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plumbline {

/// Angle wrapped to (-pi, pi].
double WrapAngle(double angle_rad);

/// Upright poses for one direction of gravity. `object` +z maps exactly onto `up_in_world`; azimuth
/// is the angle from h (world +x made horizontal; world +y if |up.x| > 0.9) to the object's +x,
/// right-handed about up. In a z-up world it equals atan2(R10, R00). The paper's theta turns about
/// gravity, which points down: theta = -azimuth. See docs/conventions.md.
class UprightFrame {
 public:
  /// @param gravity_in_world  Direction of gravity (down), any length > 0.
  explicit UprightFrame(const Eigen::Vector3d& gravity_in_world);

  const Eigen::Vector3d& up_in_world() const { return up_in_world_; }
  Eigen::Vector3d gravity_in_world() const { return -up_in_world_; }
  /// [h, up x h, up]: the rotation of an object at azimuth 0.
  const Eigen::Matrix3d& upright_rotation() const { return upright_; }

  Eigen::Matrix3d WorldFromObjectRotation(double azimuth_rad) const;
  /// Azimuth of a rotation in (-pi, pi]; for one that is not upright, of its object's +x made
  /// horizontal.
  double Azimuth(const Eigen::Matrix3d& world_from_object_rotation) const;
  /// Angle between the object's +z and up [rad].
  double Tilt(const Eigen::Matrix3d& world_from_object_rotation) const;

 private:
  Eigen::Vector3d up_in_world_;
  Eigen::Matrix3d upright_;
};

}  // namespace plumbline
