// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/triangulation.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace plumbline {
namespace {

constexpr int kMaxSteps = 6;

/// The point nearest to all rays; nothing for rays that are parallel.
std::optional<Eigen::Vector3d> NearestToRays(std::span<const Sight> sights) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Sight& sight : sights) {
    const Eigen::Vector3d d = sight.world_from_cam.linear() * sight.ray;
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    sum += across;
    right += across * sight.world_from_cam.translation();
  }
  const Eigen::LDLT<Eigen::Matrix3d> factor(sum);
  const Eigen::Vector3d point = factor.solve(right);
  if (!point.allFinite() || factor.vectorD().minCoeff() < 1e-9) return std::nullopt;
  return point;
}

/// Fits (X/Z, Y/Z, 1/Z) of one camera to the sights that are used.
class PointFit {
 public:
  PointFit(const DistortedCamera& camera, std::span<const Sight> sights, double scale_px)
      : camera_(camera), used(sights.size(), true), scale_px_(scale_px) {
    for (const Sight& sight : sights) {
      relative_.push_back(sight.world_from_cam.inverse() * sights.back().world_from_cam);
      pixels_.push_back(sight.pixel);
    }
  }

  /// Residual of one sight [px]; nothing where the point is not seen.
  std::optional<Eigen::Vector2d> Residual(std::size_t i,
                                          Eigen::Matrix<double, 2, 3>* by_value = nullptr) const {
    const Eigen::Matrix3d R = relative_[i].linear();
    const Eigen::Vector3d t = relative_[i].translation();
    // The point times its inverse depth: the pixel is the same, and it stays finite far away.
    const Eigen::Vector3d scaled = R * Eigen::Vector3d(value.x(), value.y(), 1) + value.z() * t;
    const auto projection = camera_.Project(scaled);
    if (!projection) return std::nullopt;
    if (by_value != nullptr) {
      Eigen::Matrix3d moves;
      moves << R.col(0), R.col(1), t;
      *by_value = projection->pixel_by_point * moves;
    }
    return pixels_[i] - projection->pixel;
  }

  /// Gauss-Newton with Huber's weights. @return whether it came to rest at a visible point.
  bool Solve() {
    for (int step = 0; step < kMaxSteps; ++step) {
      information.setZero();
      Eigen::Vector3d right = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < relative_.size(); ++i) {
        if (!used[i]) continue;
        Eigen::Matrix<double, 2, 3> J;
        const auto residual = Residual(i, &J);
        if (!residual) return false;
        const double size = residual->norm() / scale_px_;
        const double weight = size > 1.5 ? 1.5 / size : 1;
        information += weight * J.transpose() * J;
        right += weight * J.transpose() * *residual;
      }
      Eigen::Vector3d change = information.ldlt().solve(right);
      if (!change.allFinite()) return false;
      // Not behind the camera, and not from near to far in one step.
      if (value.z() + change.z() < 0.1 * value.z())
        change *= 0.9 * value.z() / std::abs(change.z());
      value += change;
      if (change.cwiseAbs().maxCoeff() < 1e-7) break;
    }
    return value.allFinite();
  }

  Eigen::Vector3d value{0, 0, 1};
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();

 private:
  const DistortedCamera& camera_;

 public:
  std::vector<bool> used;

 private:
  double scale_px_;
  std::vector<Eigen::Isometry3d> relative_;
  std::vector<Eigen::Vector2d> pixels_;
};

/// Leaves the worst sights out. @return how many; nothing where too many would have to go.
std::optional<int> LeaveOut(PointFit& fit, double limit_px) {
  int out = 0;
  std::size_t left = 0;
  for (std::size_t i = 0; i < fit.used.size(); ++i) {
    if (!fit.used[i]) continue;
    const auto residual = fit.Residual(i);
    if (residual && residual->norm() <= limit_px) {
      ++left;
    } else {
      fit.used[i] = false;
      ++out;
    }
  }
  if (left < 2 || 3 * left < 2 * fit.used.size()) return std::nullopt;
  return out;
}

}  // namespace

std::optional<TriangulatedPoint> Triangulate(const DistortedCamera& camera,
                                             std::span<const Sight> sights,
                                             const TriangulationOptions& options) {
  if (sights.size() < 2) return std::nullopt;
  const auto start = NearestToRays(sights);
  PointFit fit(camera, sights, options.pixel_noise_px);
  const Eigen::Vector3d ray = sights.back().ray;
  if (!(ray.z() > 0.05)) return std::nullopt;
  fit.value << ray.x() / ray.z(), ray.y() / ray.z(), 2 / options.max_depth_m;
  if (start) {
    const Eigen::Vector3d in_cam = sights.back().world_from_cam.inverse() * *start;
    if (in_cam.z() > options.min_depth_m) fit.value.z() = 1 / in_cam.z();
  }
  if (!fit.Solve()) return std::nullopt;
  const auto left_out = LeaveOut(fit, options.outlier_sigmas * options.pixel_noise_px);
  if (!left_out || (*left_out > 0 && !fit.Solve())) return std::nullopt;
  if (fit.value.z() > 1 / options.min_depth_m) return std::nullopt;
  fit.value.z() = std::max(fit.value.z(), 1 / options.max_depth_m);
  const double spread = options.pixel_noise_px * std::sqrt(fit.information.inverse()(2, 2));
  if (!(spread < options.max_depth_spread * fit.value.z())) return std::nullopt;
  const Eigen::Vector3d in_cam = Eigen::Vector3d(fit.value.x(), fit.value.y(), 1) / fit.value.z();
  return TriangulatedPoint{sights.back().world_from_cam * in_cam, fit.value, fit.used};
}

}  // namespace plumbline
