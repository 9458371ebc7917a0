// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/gravity.h"

#include <cmath>
#include <numbers>

#include "engine/base/check.h"

namespace plumbline {

double WrapAngle(double angle_rad) {
  // remainder() is slow, and particles ask for it all the time. Between half a turn and one and a
  // half the difference is exact, too (Sterbenz), so that they are the same.
  if (angle_rad > -std::numbers::pi && angle_rad <= std::numbers::pi) return angle_rad;
  const double wrapped = std::abs(angle_rad) < 3.0 * std::numbers::pi
                             ? angle_rad - std::copysign(2.0 * std::numbers::pi, angle_rad)
                             : std::remainder(angle_rad, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? wrapped + 2.0 * std::numbers::pi : wrapped;
}

UprightFrame::UprightFrame(const Eigen::Vector3d& gravity_in_world) {
  PLB_CHECK(gravity_in_world.allFinite() && gravity_in_world.norm() > 1e-9)
      << "gravity has no direction";
  up_in_world_ = -gravity_in_world.normalized();
  const Eigen::Vector3d reference =
      std::abs(up_in_world_.x()) > 0.9 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
  const Eigen::Vector3d h = (reference - reference.dot(up_in_world_) * up_in_world_).normalized();
  upright_ << h, up_in_world_.cross(h), up_in_world_;
}

Eigen::Matrix3d UprightFrame::WorldFromObjectRotation(double azimuth_rad) const {
  // AngleAxis(a, up) * upright_, written in the basis of upright_ so that its third column stays
  // `up` exactly.
  Eigen::Matrix3d rotation;
  const double c = std::cos(azimuth_rad), s = std::sin(azimuth_rad);
  rotation << c * upright_.col(0) + s * upright_.col(1), c * upright_.col(1) - s * upright_.col(0),
      up_in_world_;
  return rotation;
}

double UprightFrame::Azimuth(const Eigen::Matrix3d& world_from_object_rotation) const {
  const Eigen::Vector3d x = world_from_object_rotation.col(0);
  return std::atan2(upright_.col(1).dot(x), upright_.col(0).dot(x));
}

double UprightFrame::Tilt(const Eigen::Matrix3d& world_from_object_rotation) const {
  const Eigen::Vector3d z = world_from_object_rotation.col(2);
  return std::atan2(z.cross(up_in_world_).norm(), z.dot(up_in_world_));
}

}  // namespace plumbline
