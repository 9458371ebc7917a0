// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/body_path.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;
using Eigen::Vector4d;
constexpr double kStep = 0.01, kMargin = 1;  // [s]

Eigen::Matrix3d Turn(const Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  if (angle < 1e-12) return Eigen::Matrix3d::Identity();
  return AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

Vector3d TurnBetween(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const AngleAxisd turn(Eigen::Matrix3d(from.linear().transpose() * to.linear()));
  return turn.angle() * turn.axis();
}

/// Shares of the three steps between four knots that are done at `s`, and their derivatives by s.
Vector3d StepsDone(double s) {
  const double s2 = s * s, s3 = s2 * s;
  return Vector3d(5 + 3 * s - 3 * s2 + s3, 1 + 3 * s + 3 * s2 - 2 * s3, s3) / 6;
}
Vector3d StepsDoneRate(double s) {
  return Vector3d(1 - 2 * s + s * s, 1 + 2 * s - 2 * s * s, s * s) / 2;
}

}  // namespace

BodyPath::BodyPath(const std::function<Eigen::Isometry3d(double t_s)>& room_from_body,
                   double seconds) {
  const int count = static_cast<int>(std::ceil((seconds + 2 * kMargin) / kStep)) + 1;
  for (int k = 0; k < count; ++k) knots_.push_back(room_from_body(k * kStep - kMargin));
}

BodyPath::Place BodyPath::PlaceAt(double t_s) const {
  const double at =
      std::clamp((t_s + kMargin) / kStep, 1.0, static_cast<double>(knots_.size()) - 2.001);
  const double whole = std::floor(at);
  return {static_cast<std::size_t>(whole) - 1, at - whole};
}

Vector3d BodyPath::Weighted(std::size_t first, const Vector4d& weights) const {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = 0; k < 4; ++k)
    sum += weights[static_cast<Eigen::Index>(k)] * knots_[first + k].translation();
  return sum;
}

Eigen::Isometry3d BodyPath::RoomFromBody(double t_s) const {
  const auto [first, s] = PlaceAt(t_s);
  const Vector3d done = StepsDone(s);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = knots_[first].linear();
  for (int k = 0; k < 3; ++k) {
    const std::size_t from = first + static_cast<std::size_t>(k);
    pose.linear() = pose.linear() * Turn(done[k] * TurnBetween(knots_[from], knots_[from + 1]));
  }
  pose.translation() =
      Weighted(first, {1 - done[0], done[0] - done[1], done[1] - done[2], done[2]});
  return pose;
}

Vector3d BodyPath::VelocityInRoom(double t_s) const {
  const auto [first, s] = PlaceAt(t_s);
  const Vector3d rate = StepsDoneRate(s) / kStep;
  return Weighted(first, {-rate[0], rate[0] - rate[1], rate[1] - rate[2], rate[2]});
}

Vector3d BodyPath::AccelerationInRoom(double t_s) const {
  const auto [first, s] = PlaceAt(t_s);
  return Weighted(first, Vector4d(1 - s, 3 * s - 2, 1 - 3 * s, s) / (kStep * kStep));
}

Vector3d BodyPath::AngularVelocityInBody(double t_s) const {
  const auto [first, s] = PlaceAt(t_s);
  const Vector3d done = StepsDone(s), rate = StepsDoneRate(s) / kStep;
  Vector3d angular_velocity = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const std::size_t from = first + static_cast<std::size_t>(k);
    const Vector3d turn = TurnBetween(knots_[from], knots_[from + 1]);
    angular_velocity = Turn(-done[k] * turn) * angular_velocity + rate[k] * turn;
  }
  return angular_velocity;
}

double TimeAfterRest(double t_s, double rest_s) {
  if (rest_s <= 0) return t_s;
  const double s = t_s - rest_s;
  if (s <= 0) return 0;
  if (s >= 1) return s - 0.5;
  return s * s * s * s * (2.5 - 3 * s + s * s);  // its rate is 10 s^3 - 15 s^4 + 6 s^5
}

}  // namespace plumbline
