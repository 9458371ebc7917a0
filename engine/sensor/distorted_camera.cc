// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/distorted_camera.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/LU>

namespace plumbline {
namespace {

constexpr double kHalfTurn = std::numbers::pi;
/// Rays of a bearing are within this of the axis: at 89 degrees x = X/Z is 57.
constexpr double kMaxBearingAngle = 89.0 / 180 * kHalfTurn;
constexpr int kMaxSteps = 50;

/// The first place from 0 on where `slope` is no longer positive, at most `end`.
template <typename Slope>
double RisesUpTo(double end, const Slope& slope) {
  constexpr int kSteps = 2000;
  for (int i = 0; i <= kSteps; ++i) {
    const double at = end * i / kSteps;
    if (slope(at) > 0) continue;
    double low = std::max(0.0, end * (i - 1) / kSteps), high = at;
    for (int halving = 0; halving < 50; ++halving) {
      const double middle = (low + high) / 2;
      (slope(middle) > 0 ? low : high) = middle;
    }
    return low;
  }
  return end;
}

/// x with value(x) = wanted for a rising function on [0, end]; nothing beyond its value at `end`.
template <typename Function>
std::optional<double> InvertRising(double wanted, double end, const Function& function) {
  if (wanted > function(end).value) return std::nullopt;
  double low = 0, high = end, x = std::min(wanted, end);
  for (int i = 0; i < kMaxSteps; ++i) {
    const auto [value, slope] = function(x);
    (value < wanted ? low : high) = x;
    double next = x - (value - wanted) / slope;
    if (!(next > low && next < high)) next = (low + high) / 2;
    if (std::abs(next - x) < 1e-15) return next;
    x = next;
  }
  return x;
}

}  // namespace

DistortedCamera::DistortedCamera(const Camera& camera)
    : model_(camera.model), pinhole_(camera.pinhole) {
  std::copy(camera.distortion.begin(), camera.distortion.end(), k_.begin());
  FindMaxAngle();
}

void DistortedCamera::FindMaxAngle() {
  switch (model_) {
    case CameraModel::kPinhole:
      max_angle_rad_ = kMaxBearingAngle;
      break;
    case CameraModel::kRadialTangential:
      max_angle_rad_ = RisesUpTo(kMaxBearingAngle,
                                 [&](double angle) { return RadialAt(std::tan(angle)).slope; });
      break;
    case CameraModel::kEquidistant:
      max_angle_rad_ = RisesUpTo(kHalfTurn, [&](double angle) { return RadiusAt(angle).slope; });
      break;
    case CameraModel::kFov:
      max_angle_rad_ = kMaxBearingAngle;
      break;
  }
}

DistortedCamera::Radius DistortedCamera::RadiusAt(double angle_rad) const {
  if (model_ == CameraModel::kFov) {
    const double w = k_[0], tangent = 2 * std::tan(w / 2);
    const double sine = std::sin(angle_rad), cosine = std::cos(angle_rad);
    return {std::atan2(tangent * sine, cosine) / w,
            tangent / (w * (cosine * cosine + tangent * tangent * sine * sine))};
  }
  const double s = angle_rad * angle_rad;
  return {angle_rad * (1 + s * (k_[0] + s * (k_[1] + s * (k_[2] + s * k_[3])))),
          1 + s * (3 * k_[0] + s * (5 * k_[1] + s * (7 * k_[2] + s * 9 * k_[3])))};
}

DistortedCamera::Radius DistortedCamera::RadialAt(double distance) const {
  const double k1 = k_[0], k2 = k_[1], k3 = k_[4], s = distance * distance;
  return {distance * (1 + s * (k1 + s * (k2 + s * k3))),
          1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3))};
}

std::pair<Eigen::Vector2d, Eigen::Matrix2d> DistortedCamera::Bend(
    const Eigen::Vector2d& bearing) const {
  if (model_ == CameraModel::kPinhole) return {bearing, Eigen::Matrix2d::Identity()};
  const double k1 = k_[0], k2 = k_[1], p1 = k_[2], p2 = k_[3], k3 = k_[4];
  const double x = bearing.x(), y = bearing.y(), s = bearing.squaredNorm();
  const double radial = 1 + s * (k1 + s * (k2 + s * k3));
  const double radial_by_s = k1 + s * (2 * k2 + s * 3 * k3);
  const Eigen::Vector2d m(x * radial + 2 * p1 * x * y + p2 * (s + 2 * x * x),
                          y * radial + p1 * (s + 2 * y * y) + 2 * p2 * x * y);
  const double cross = 2 * x * y * radial_by_s + 2 * p1 * x + 2 * p2 * y;
  Eigen::Matrix2d m_by_bearing;
  m_by_bearing << radial + 2 * x * x * radial_by_s + 2 * p1 * y + 6 * p2 * x, cross, cross,
      radial + 2 * y * y * radial_by_s + 6 * p1 * y + 2 * p2 * x;
  return {m, m_by_bearing};
}

std::optional<Projection> DistortedCamera::Project(const Eigen::Vector3d& point_in_cam) const {
  const double X = point_in_cam.x(), Y = point_in_cam.y(), Z = point_in_cam.z();
  const double r = std::hypot(X, Y);
  if (!(std::atan2(r, Z) <= max_angle_rad_) || (r == 0 && !(Z > 0))) return std::nullopt;
  Eigen::Vector2d m;
  Eigen::Matrix<double, 2, 3> m_by_point;
  if (bends_bearings()) {
    const Eigen::Vector2d bearing(X / Z, Y / Z);
    Eigen::Matrix<double, 2, 3> bearing_by_point;
    bearing_by_point << 1 / Z, 0, -bearing.x() / Z, 0, 1 / Z, -bearing.y() / Z;
    const auto [bent, by_bearing] = Bend(bearing);
    m = bent;
    m_by_point = by_bearing * bearing_by_point;
  } else if (r < 1e-9 * Z) {  // on the axis the direction (X, Y) / r is not defined, its limit is
    const double scale = RadiusAt(0).slope / Z;
    m << scale * X, scale * Y;
    m_by_point << scale, 0, -m.x() / Z, 0, scale, -m.y() / Z;
  } else {
    const auto [g, slope] = RadiusAt(std::atan2(r, Z));
    const Eigen::Vector2d direction(X / r, Y / r);
    const double square = r * r + Z * Z;
    m = g * direction;
    m_by_point.leftCols<2>() = (slope * Z / square - g / r) * direction * direction.transpose() +
                               g / r * Eigen::Matrix2d::Identity();
    m_by_point.col(2) = -slope * r / square * direction;
  }
  Projection result;
  result.pixel << pinhole_.fx * m.x() + pinhole_.cx, pinhole_.fy * m.y() + pinhole_.cy;
  result.pixel_by_point << pinhole_.fx * m_by_point.row(0), pinhole_.fy * m_by_point.row(1);
  return result;
}

DistortedCamera::Intrinsics DistortedCamera::intrinsics() const {
  Intrinsics values;
  values << pinhole_.fx, pinhole_.fy, pinhole_.cx, pinhole_.cy, k_[0], k_[1], k_[2], k_[3];
  return values;
}

DistortedCamera DistortedCamera::With(const Intrinsics& intrinsics) const {
  DistortedCamera camera = *this;
  camera.pinhole_.fx = intrinsics[0];
  camera.pinhole_.fy = intrinsics[1];
  camera.pinhole_.cx = intrinsics[2];
  camera.pinhole_.cy = intrinsics[3];
  for (int i = 0; i < 4; ++i) camera.k_[static_cast<std::size_t>(i)] = intrinsics[4 + i];
  camera.FindMaxAngle();
  return camera;
}

Eigen::Matrix<double, 2, 8> DistortedCamera::PixelByIntrinsics(
    const Eigen::Vector3d& point_in_cam) const {
  const double X = point_in_cam.x(), Y = point_in_cam.y(), Z = point_in_cam.z();
  Eigen::Vector2d m(X / Z, Y / Z);
  Eigen::Matrix<double, 2, 4> m_by_lens = Eigen::Matrix<double, 2, 4>::Zero();
  const double r = std::hypot(X, Y), angle = std::atan2(r, Z);
  const Eigen::Vector2d direction = r > 0 ? Eigen::Vector2d(X / r, Y / r) : Eigen::Vector2d::Zero();
  switch (model_) {
    case CameraModel::kPinhole:
      break;
    case CameraModel::kRadialTangential: {
      const double x = m.x(), y = m.y(), s = m.squaredNorm();
      m_by_lens << x * s, x * s * s, 2 * x * y, s + 2 * x * x,  //
          y * s, y * s * s, s + 2 * y * y, 2 * x * y;
      m = Bend(m).first;
      break;
    }
    case CameraModel::kEquidistant: {
      double power = angle;
      for (int i = 0; i < 4; ++i) m_by_lens.col(i) = (power *= angle * angle) * direction;
      m = RadiusAt(angle).value * direction;
      break;
    }
    case CameraModel::kFov: {
      const double w = k_[0], tangent = 2 * std::tan(w / 2);
      const double sine = std::sin(angle), cosine = std::cos(angle);
      const double by_tangent = sine * cosine / (cosine * cosine + tangent * tangent * sine * sine);
      const double tangent_by_w = 1 + tangent * tangent / 4;
      m = RadiusAt(angle).value * direction;
      m_by_lens.col(0) = (by_tangent * tangent_by_w / w) * direction - m / w;
      break;
    }
  }
  Eigen::Matrix<double, 2, 8> result;
  result << m.x(), 0, 1, 0, pinhole_.fx * m_by_lens.row(0),  //
      0, m.y(), 0, 1, pinhole_.fy * m_by_lens.row(1);
  return result;
}

std::optional<Eigen::Vector3d> DistortedCamera::UnbendToRay(const Eigen::Vector2d& m) const {
  if (!bends_bearings()) {
    const double radius = m.norm();
    const auto angle =
        InvertRising(radius, max_angle_rad_, [&](double at) { return RadiusAt(at); });
    if (!angle) return std::nullopt;
    if (radius < 1e-12) return Eigen::Vector3d(m.x(), m.y(), RadiusAt(0).slope).normalized();
    const double sine = std::sin(*angle) / radius;
    return Eigen::Vector3d(sine * m.x(), sine * m.y(), std::cos(*angle));
  }
  // Newton from the place that is right without the tangential part.
  Eigen::Vector2d bearing = m;
  if (model_ == CameraModel::kRadialTangential && m.norm() > 0) {
    const double end = std::tan(max_angle_rad_);
    const auto distance = InvertRising(m.norm(), end, [&](double at) { return RadialAt(at); });
    bearing *= distance.value_or(end) / m.norm();
  }
  for (int i = 0; i < kMaxSteps; ++i) {
    const auto [bent, by_bearing] = Bend(bearing);
    const Eigen::Vector2d step = by_bearing.inverse() * (m - bent);
    if (!step.allFinite()) return std::nullopt;
    bearing += step;
    if (step.norm() > 1e-14 * (1 + bearing.norm())) continue;
    if (std::atan(bearing.norm()) > max_angle_rad_) return std::nullopt;
    return bearing.homogeneous().normalized();
  }
  const double rest = (Bend(bearing).first - m).norm();
  if (!(rest < 1e-10) || std::atan(bearing.norm()) > max_angle_rad_) return std::nullopt;
  return bearing.homogeneous().normalized();
}

std::optional<Eigen::Vector3d> DistortedCamera::Unproject(const Eigen::Vector2d& pixel) const {
  return UnbendToRay(pinhole_.Bearing(pixel));
}

}  // namespace plumbline
