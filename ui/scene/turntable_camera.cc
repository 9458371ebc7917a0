// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/turntable_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {
constexpr double kSteepest = 1.553;  // 89 degrees: beyond it, up would flip
}

TurntableCamera::TurntableCamera(const Eigen::Vector3d& up_in_world)
    : world_from_upright_(UprightFrame(-up_in_world).upright_rotation()) {}

void TurntableCamera::Orbit(double azimuth_rad, double elevation_rad) {
  SetDirection(azimuth_rad_ + azimuth_rad, elevation_rad_ + elevation_rad);
}

void TurntableCamera::SetDirection(double azimuth_rad, double elevation_rad) {
  azimuth_rad_ = WrapAngle(azimuth_rad);
  elevation_rad_ = std::clamp(elevation_rad, -kSteepest, kSteepest);
}

void TurntableCamera::Pan(double right, double up) {
  const double height_m = 2 * distance_m_ * std::tan(0.5 * kViewAngle);
  const Eigen::Matrix3d view = view_from_world();
  focus_in_world_ += height_m * (right * view.row(0) + up * view.row(1)).transpose();
}

void TurntableCamera::Zoom(double factor) {
  distance_m_ = std::clamp(distance_m_ * factor, 0.05, 500.0);
}

void TurntableCamera::LookAt(const Eigen::Vector3d& focus_in_world, double distance_m) {
  focus_in_world_ = focus_in_world;
  distance_m_ = std::clamp(distance_m, 0.05, 500.0);
}

void TurntableCamera::Frame(std::span<const Eigen::Vector3d> points_in_world, double aspect) {
  constexpr double kMargin = 1.1;
  const double half_height = std::tan(0.5 * kViewAngle) / kMargin;
  const Eigen::Array2d half(aspect * half_height, half_height);
  const Eigen::Matrix3d view = view_from_world();
  // Both sides of the picture are met by a point each: in each direction, the lines of sight at its
  // two edges cross at the eye. Of the two distances the larger one serves.
  Eigen::AlignedBox3d box;
  Eigen::Array2d low, high;
  low.setConstant(std::numeric_limits<double>::max());
  high = -low;
  for (const Eigen::Vector3d& point : points_in_world) {
    const Eigen::Vector3d p = view * point;
    const double depth = parallel_ ? 0 : p.z();
    low = low.min(p.head<2>().array() - depth * half);
    high = high.max(p.head<2>().array() + depth * half);
    box.extend(p);
  }
  const double eye_z = ((high - low) / (2 * half)).maxCoeff();
  const Eigen::Array2d middle = 0.5 * (low + high);
  const double focus_z = parallel_ ? box.center().z() : std::min(box.center().z(), eye_z - 0.05);
  LookAt(view.transpose() * Eigen::Vector3d(middle.x(), middle.y(), focus_z),
         parallel_ ? eye_z : eye_z - focus_z);
}

Eigen::Matrix3d TurntableCamera::view_from_world() const {
  const Eigen::Vector3d back_in_upright(std::cos(elevation_rad_) * std::cos(azimuth_rad_),
                                        std::cos(elevation_rad_) * std::sin(azimuth_rad_),
                                        std::sin(elevation_rad_));
  const Eigen::Vector3d back = world_from_upright_ * back_in_upright;
  const Eigen::Vector3d right = world_from_upright_.col(2).cross(back).normalized();
  Eigen::Matrix3d view;
  view.row(0) = right;
  view.row(1) = back.cross(right);
  view.row(2) = back;
  return view;
}

Eigen::Vector3d TurntableCamera::eye_in_world() const {
  return focus_in_world_ + distance_m_ * view_from_world().row(2).transpose();
}

}  // namespace plumbline
