// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/rotation.h"

#include <cmath>

#include <Eigen/Geometry>

namespace plumbline {
namespace {

/// Below this angle [rad] series replace quotients that lose their digits.
constexpr double kSmallTurn = 1e-2;

/// I + a [turn]x + b [turn]x^2.
Eigen::Matrix3d RotationSeries(double first, double a, double b, const Eigen::Vector3d& turn) {
  const Eigen::Matrix3d hat = Hat(turn);
  return first * Eigen::Matrix3d::Identity() + a * hat + b * hat * hat;
}

}  // namespace

Eigen::Matrix3d Hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d hat;
  hat << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return hat;
}

Eigen::Matrix3d RotationExp(const Eigen::Vector3d& turn) {
  const double s = turn.squaredNorm(), angle = std::sqrt(s);
  if (angle < kSmallTurn)
    return RotationSeries(1, 1 - s / 6 * (1 - s / 20), 0.5 - s / 24 * (1 - s / 30), turn);
  return RotationSeries(1, std::sin(angle) / angle, (1 - std::cos(angle)) / s, turn);
}

Eigen::Vector3d RotationLog(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn{Eigen::Quaterniond(rotation)};
  return turn.angle() * turn.axis();
}

Eigen::Matrix3d LeftJacobian(const Eigen::Vector3d& turn) {
  const double s = turn.squaredNorm(), angle = std::sqrt(s);
  if (angle < kSmallTurn) {
    return RotationSeries(1, 0.5 - s / 24 * (1 - s / 30), 1.0 / 6 - s / 120 * (1 - s / 42), turn);
  }
  return RotationSeries(1, (1 - std::cos(angle)) / s, (angle - std::sin(angle)) / (s * angle),
                        turn);
}

Eigen::Matrix3d SecondIntegral(const Eigen::Vector3d& turn) {
  const double s = turn.squaredNorm(), angle = std::sqrt(s);
  if (angle < 10 * kSmallTurn) {
    return RotationSeries(0.5, 1.0 / 6 - s / 120 * (1 - s / 42), 1.0 / 24 - s / 720 * (1 - s / 56),
                          turn);
  }
  return RotationSeries(0.5, (angle - std::sin(angle)) / (s * angle),
                        (s / 2 + std::cos(angle) - 1) / (s * s), turn);
}

Eigen::Matrix3d Orthonormal(const Eigen::Matrix3d& rotation) {
  return Eigen::Quaterniond(rotation).normalized().toRotationMatrix();
}

}  // namespace plumbline
