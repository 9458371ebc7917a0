// SPDX-License-Identifier: Apache-2.0
#include "ui/scene/turntable_camera.h"

#include <algorithm>
#include <cmath>

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
