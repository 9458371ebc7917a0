// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/motion_test.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace plumbline {
namespace {}  // namespace

void MotionTest::Add(std::int64_t stamp_ns, const Box2& box, const Eigen::Vector2d& place_m,
                     const Eigen::Matrix2d& information) {
  last_box_ = box;
  if (boxes_++ == 0) {
    first_ns_ = stamp_ns;
    first_m_ = place_m;
  }
  const double t_s = static_cast<double>(stamp_ns - first_ns_) * 1e-9;
  const Eigen::Vector2d pull = information * (place_m - first_m_);
  weight_ += information;
  weight_t_ += t_s * information;
  weight_tt_ += t_s * t_s * information;
  place_ += pull;
  place_t_ += t_s * pull;
}

MotionTest::Reduced MotionTest::OfVelocity() const {
  const Eigen::Matrix2d gain = weight_t_ * weight_.inverse();
  return {weight_tt_ - gain * weight_t_, place_t_ - gain * place_};
}

double MotionTest::LogBayesFactor(const MapperOptions& options) const {
  if (boxes_ < kLeastBoxes) return 0;
  const Reduced of = OfVelocity();
  const auto log_marginal = [&](double speed_m_s) {
    const double variance = speed_m_s * speed_m_s;
    const Eigen::Matrix2d posterior = of.information + Eigen::Matrix2d::Identity() / variance;
    const double determinant =
        (Eigen::Matrix2d::Identity() + variance * of.information).determinant();
    return 0.5 * of.pull.dot(posterior.inverse() * of.pull) - 0.5 * std::log(determinant);
  };
  return log_marginal(options.moving_speed_m_s) - log_marginal(options.feigned_speed_m_s);
}

double MotionTest::LogStanding(const MapperOptions& options) const {
  if (options.moving_share <= 0) return 0;
  const double odds =
      std::log(options.moving_share / (1 - options.moving_share)) + LogBayesFactor(options);
  return odds > 0 ? -odds - std::log1p(std::exp(-odds)) : -std::log1p(std::exp(odds));
}

double MotionTest::LogAgainst(const MapperOptions& options) const {
  return std::min(0.0, LogStanding(options) - std::log1p(-options.moving_share));
}

Eigen::Vector2d MotionTest::Velocity(const MapperOptions& options) const {
  if (boxes_ < 2) return Eigen::Vector2d::Zero();
  const Reduced of = OfVelocity();
  const double variance = options.moving_speed_m_s * options.moving_speed_m_s;
  return (of.information + Eigen::Matrix2d::Identity() / variance).inverse() * of.pull;
}

void MotionTest::Save(ByteWriter& out) const {
  out.Put(boxes_);
  for (const float side : {last_box_.x0, last_box_.y0, last_box_.x1, last_box_.y1}) out.Put(side);
  out.Put(first_ns_);
  for (const double value : first_m_.reshaped()) out.Put(value);
  for (const Eigen::Matrix2d* sum : {&weight_, &weight_t_, &weight_tt_})
    for (const double value : sum->reshaped()) out.Put(value);
  for (const Eigen::Vector2d* sum : {&place_, &place_t_})
    for (const double value : sum->reshaped()) out.Put(value);
}

void MotionTest::Restore(ByteReader& in) {
  boxes_ = in.Get<std::int32_t>();
  for (float* side : {&last_box_.x0, &last_box_.y0, &last_box_.x1, &last_box_.y1})
    *side = in.Get<float>();
  first_ns_ = in.Get<std::int64_t>();
  for (double& value : first_m_.reshaped()) value = in.Get<double>();
  for (Eigen::Matrix2d* sum : {&weight_, &weight_t_, &weight_tt_})
    for (double& value : sum->reshaped()) value = in.Get<double>();
  for (Eigen::Vector2d* sum : {&place_, &place_t_})
    for (double& value : sum->reshaped()) value = in.Get<double>();
}

}  // namespace plumbline
