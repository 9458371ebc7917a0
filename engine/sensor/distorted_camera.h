// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "engine/sensor/camera.h"

namespace plumbline {

/// A pixel of the recorded image and how it moves with the point.
struct Projection {
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> pixel_by_point;  ///< Derivative by the point in `cam` [px / m].
};

/// The camera of the image as recorded, distortion included: for tracking, which works on the
/// recorded pixels. With a point (X, Y, Z), r = hypot(X, Y), x = X/Z, y = Y/Z, the pixel is
/// (fx mx + cx, fy my + cy) with
///
///   pinhole            m = (x, y)
///   radial_tangential  m = (x, y) (1 + k1 s + k2 s^2 + k3 s^3) + tangential, s = x^2 + y^2
///   equidistant        m = (X, Y) / r * (t + k1 t^3 + k2 t^5 + k3 t^7 + k4 t^9), t = atan2(r, Z)
///   fov                m = (X, Y) / r * atan(2 tan(w/2) r / Z) / w
///
/// A model holds as far from the axis as its radius rises; beyond, there is no pixel. Immutable.
class DistortedCamera {
 public:
  explicit DistortedCamera(const Camera& camera);

  /// Nothing for a point behind the camera (equidistant lenses see behind it) or beyond the angle
  /// up to which the model holds. The pixel may lie outside of the image.
  std::optional<Projection> Project(const Eigen::Vector3d& point_in_cam) const;

  /// The unit ray in `cam` that is seen in a pixel; nothing where the model has none. Inverse of
  /// Project to 1e-9.
  std::optional<Eigen::Vector3d> Unproject(const Eigen::Vector2d& pixel) const;

  /// fx, fy, cx, cy [px], then the first four coefficients of the lens; 0 where it has fewer.
  using Intrinsics = Eigen::Matrix<double, 8, 1>;
  Intrinsics intrinsics() const;
  /// The same model with other numbers; a fifth coefficient stays.
  DistortedCamera With(const Intrinsics& intrinsics) const;
  /// How the pixel of a point that Project() sees moves with them.
  Eigen::Matrix<double, 2, 8> PixelByIntrinsics(const Eigen::Vector3d& point_in_cam) const;

  /// The angle from the axis up to which the model holds [rad].
  double max_angle_rad() const { return max_angle_rad_; }

 private:
  void FindMaxAngle();
  struct Radius {
    double value, slope;
  };
  /// Distance from the axis in the plane m, of a ray at an angle from the axis (equidistant, fov).
  Radius RadiusAt(double angle_rad) const;
  /// Distance from the axis in the plane m, without the tangential part (radial_tangential).
  Radius RadialAt(double distance) const;
  /// m and its derivative by (x, y).
  std::pair<Eigen::Vector2d, Eigen::Matrix2d> Bend(const Eigen::Vector2d& bearing) const;
  std::optional<Eigen::Vector3d> UnbendToRay(const Eigen::Vector2d& m) const;
  bool bends_bearings() const {
    return model_ == CameraModel::kPinhole || model_ == CameraModel::kRadialTangential;
  }

  CameraModel model_;
  PinholeCamera pinhole_;
  std::array<double, 5> k_{};
  double max_angle_rad_ = 0;
};

}  // namespace plumbline
