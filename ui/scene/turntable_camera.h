// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

namespace plumbline {

inline constexpr double kOrbitPerPixel = 0.006;  ///< Radians that a drag turns the view.
/// A view that takes longer to draw goes coarser while it moves.
inline constexpr double kSlowRenderMs = 30;

/// A camera that turns about a point with up fixed: azimuth about up, elevation above the horizon.
/// Azimuth 0 looks from h (world +x made horizontal) towards the focus.
class TurntableCamera {
 public:
  explicit TurntableCamera(const Eigen::Vector3d& up_in_world = Eigen::Vector3d::UnitZ());

  void Orbit(double azimuth_rad, double elevation_rad);
  /// Moves the focus in the image plane by shares of the picture's height (right, up).
  void Pan(double right, double up);
  /// Factor on the distance, kept between 5 cm and 500 m.
  void Zoom(double factor);
  void LookAt(const Eigen::Vector3d& focus_in_world, double distance_m);
  void SetDirection(double azimuth_rad, double elevation_rad);
  /// Moves, without turning, so that the points fill the picture but for a small margin.
  /// @param points_in_world  At least one.
  /// @param aspect           Width of the picture by its height.
  void Frame(std::span<const Eigen::Vector3d> points_in_world, double aspect);
  void MoveFocus(const Eigen::Vector3d& focus_in_world) { focus_in_world_ = focus_in_world; }

  const Eigen::Vector3d& focus_in_world() const { return focus_in_world_; }
  Eigen::Vector3d eye_in_world() const;
  /// What is in front of it at any distance has its own size: distance_m() then only says how much
  /// is seen, as much as the perspective view sees about the focus.
  bool parallel() const { return parallel_; }
  void SetParallel(bool parallel) { parallel_ = parallel; }
  double azimuth_rad() const { return azimuth_rad_; }
  double elevation_rad() const { return elevation_rad_; }
  double distance_m() const { return distance_m_; }
  /// Rows right, up and towards the viewer.
  Eigen::Matrix3d view_from_world() const;
  /// Vertical opening [rad].
  static constexpr double kViewAngle = 0.7;

 private:
  Eigen::Matrix3d world_from_upright_;  // columns h, up x h, up
  Eigen::Vector3d focus_in_world_{0, 0, 0};
  double azimuth_rad_ = 0.8, elevation_rad_ = 0.6, distance_m_ = 5;
  bool parallel_ = false;
};

}  // namespace plumbline
