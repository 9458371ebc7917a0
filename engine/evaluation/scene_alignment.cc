// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/scene_alignment.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/geometry/symmetric_matrix.h"

namespace plumbline {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

Eigen::Vector3d Mean(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : points) sum += point;
  return sum / static_cast<double>(points.size());
}

/// Pairs beyond three times the median distance are things that the truth does not have.
double Gate(const std::vector<ClosestPoint>& closest, double max_distance_m) {
  std::vector<double> distances;
  for (const ClosestPoint& point : closest) {
    if (point.distance_m <= max_distance_m) distances.push_back(point.distance_m);
  }
  if (distances.empty()) return max_distance_m;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return std::min(max_distance_m, std::max(3 * *middle, 1e-6));
}

}  // namespace

Eigen::Isometry3d FitYawAndTranslation(const std::vector<Eigen::Vector3d>& estimate,
                                       const std::vector<Eigen::Vector3d>& truth,
                                       const Eigen::Vector3d& up) {
  PLB_CHECK(estimate.size() == truth.size()) << estimate.size() << " and " << truth.size();
  Eigen::Isometry3d truth_from_estimate = Eigen::Isometry3d::Identity();
  if (estimate.empty()) return truth_from_estimate;
  const Eigen::Vector3d mean_estimate = Mean(estimate), mean_truth = Mean(truth);
  double sine = 0, cosine = 0, spread = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const Eigen::Vector3d p = estimate[i] - mean_estimate, q = truth[i] - mean_truth;
    sine += up.dot(p.cross(q));
    cosine += p.dot(q) - up.dot(p) * up.dot(q);
    spread += p.cross(up).squaredNorm();
  }
  // Less than a centimetre of horizontal spread shows noise, not a turn.
  const double yaw = spread > 1e-4 ? std::atan2(sine, cosine) : 0.0;
  truth_from_estimate.linear() = Eigen::AngleAxisd(yaw, up).toRotationMatrix();
  truth_from_estimate.translation() = mean_truth - truth_from_estimate.linear() * mean_estimate;
  return truth_from_estimate;
}

Eigen::Isometry3d AlignToSurface(const std::vector<Eigen::Vector3d>& points,
                                 const ClosestTriangleSearch& surface,
                                 const std::optional<Eigen::Vector3d>& up,
                                 const IcpOptions& options) {
  Eigen::Isometry3d surface_from_points = Eigen::Isometry3d::Identity();
  if (points.empty()) return surface_from_points;
  std::vector<Eigen::Vector3d> moved(points.size());
  std::vector<ClosestPoint> closest(points.size());
  for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
    for (std::size_t i = 0; i < points.size(); ++i) moved[i] = surface_from_points * points[i];
    surface.Find(moved, closest);
    const double gate = Gate(closest, options.max_distance_m);
    // Turns about the centre of the points, so that turning and moving hardly mix.
    const Eigen::Vector3d center = Mean(moved);
    Matrix6 information = Matrix6::Zero();
    Vector6 gradient = Vector6::Zero();
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (closest[i].distance_m > gate) continue;
      const Eigen::Vector3d normal = surface.Normal(closest[i].triangle);
      const Eigen::Vector3d lever = (moved[i] - center).cross(normal);
      Vector6 row;
      row << (up ? Eigen::Vector3d(up->dot(lever) * *up) : lever), normal;
      information += row * row.transpose();
      gradient += row * normal.dot(moved[i] - closest[i].point);
    }
    // What the surface does not show (sliding along a lone table top) stays put.
    information.diagonal().array() += 1e-9 * information.trace() + 1e-12;
    const Vector6 step = -SolveSymmetric(information, gradient);
    // Of `step`, the turn is along `up` already: its other components have no gradient.
    const Eigen::Vector3d turn = step.head<3>();
    Eigen::Isometry3d update = Eigen::Isometry3d::Identity();
    if (turn.norm() > 0) {
      const Eigen::Vector3d axis = up ? *up : Eigen::Vector3d(turn.normalized());
      const double angle = up ? up->dot(turn) : turn.norm();
      update.linear() = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
    }
    update.translation() = center + step.tail<3>() - update.linear() * center;
    surface_from_points = update * surface_from_points;
    if (turn.norm() < 1e-9 && step.tail<3>().norm() < 1e-9) break;
  }
  // Products of rotations drift by rounding.
  surface_from_points.linear() =
      Eigen::Quaterniond(surface_from_points.linear()).normalized().toRotationMatrix();
  return surface_from_points;
}

}  // namespace plumbline
