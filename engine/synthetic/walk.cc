// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "engine/base/random.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr int kDirections = 96;  ///< Control points of the loop.
constexpr int kRadii = 48;
constexpr double kMinRadius = 0.7, kMaxRadius = 3.2;
constexpr int kLengthSteps = 4096;

double RadiusOf(int index) { return kMinRadius + (kMaxRadius - kMinRadius) * index / (kRadii - 1); }

Vector2d OnLoop(const WalkPlan& plan, int direction, double radius) {
  const double angle = plan.start_angle_rad + std::copysign(2 * std::numbers::pi, plan.sweep_rad) *
                                                  direction / kDirections;
  return plan.focus + radius * Vector2d(std::cos(angle), std::sin(angle));
}

/// Cheapest loop of radii by dynamic programming: near the wished radius, clear of obstacles,
/// without sharp changes.
std::optional<std::vector<double>> PlanRadii(const Room& room) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  std::vector<std::array<double, kRadii>> local(kDirections);
  for (int d = 0; d < kDirections; ++d) {
    for (int r = 0; r < kRadii; ++r) {
      const double clearance = Clearance(room, OnLoop(room.walk, d, RadiusOf(r)));
      const double off = RadiusOf(r) - room.walk.radius_m;
      const double narrow = std::max(0.0, 0.65 - clearance);
      local[d][r] =
          clearance < Walk::kClearanceM + 0.04 ? kInfinite : off * off + 6 * narrow * narrow;
    }
  }
  std::vector<double> best_radii;
  double best = kInfinite;
  constexpr int kReach = 2;
  for (int start = 0; start < kRadii; start += 2) {
    if (local[0][start] == kInfinite) continue;
    std::vector<std::array<double, kRadii>> cost(kDirections + 1);
    std::vector<std::array<int, kRadii>> from(kDirections + 1);
    cost[0].fill(kInfinite);
    cost[0][start] = local[0][start];
    for (int d = 1; d <= kDirections; ++d) {
      for (int r = 0; r < kRadii; ++r) {
        cost[d][r] = kInfinite;
        for (int q = std::max(0, r - kReach); q <= std::min(kRadii - 1, r + kReach); ++q) {
          const double step = RadiusOf(r) - RadiusOf(q);
          const double total = cost[d - 1][q] + local[d % kDirections][r] + 25 * step * step;
          if (total < cost[d][r]) {
            cost[d][r] = total;
            from[d][r] = q;
          }
        }
      }
    }
    if (cost[kDirections][start] >= best) continue;
    best = cost[kDirections][start];
    best_radii.assign(kDirections, 0);
    for (int d = kDirections, r = start; d > 0; --d) {
      r = from[d][r];
      best_radii[static_cast<std::size_t>(d - 1)] = RadiusOf(r);
    }
  }
  if (best_radii.empty()) return std::nullopt;
  return best_radii;
}

void SmoothCircularly(std::vector<double>& values, int passes) {
  const std::size_t n = values.size();
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<double> next(n);
    for (std::size_t i = 0; i < n; ++i) {
      next[i] = 0.25 * values[(i + n - 1) % n] + 0.5 * values[i] + 0.25 * values[(i + 1) % n];
    }
    values = std::move(next);
  }
}

/// @param closed  The first point follows upon the last.
Vector2d SplineAt(const std::vector<Vector2d>& control, double parameter, bool closed) {
  const int n = static_cast<int>(control.size());
  const double whole = std::floor(parameter);
  const double t = parameter - whole;
  const int i = static_cast<int>(whole);
  const auto at = [&](int k) {
    const int index = closed ? ((i + k) % n + n) % n : std::clamp(i + k, 0, n - 1);
    return control[static_cast<std::size_t>(index)];
  };
  const double a = (1 - t) * (1 - t) * (1 - t) / 6, d = t * t * t / 6;
  const double b = (3 * t * t * t - 6 * t * t + 4) / 6, c = 1 - a - b - d;
  return a * at(-1) + b * at(0) + c * at(1) + d * at(2);
}

}  // namespace

double Clearance(const Room& room, const Vector2d& point) {
  double clearance =
      std::min(room.size.x() / 2 - std::abs(point.x()), room.size.y() / 2 - std::abs(point.y()));
  for (const Footprint& footprint : room.obstacles) {
    const Vector2d local = Eigen::Rotation2Dd(-footprint.azimuth_rad) * (point - footprint.center);
    const Vector2d outside = local.cwiseAbs() - footprint.half_size;
    const double distance = outside.cwiseMax(0.0).norm() + std::min(0.0, outside.maxCoeff());
    clearance = std::min(clearance, distance);
  }
  return clearance;
}

Result<Walk> Walk::Plan(const Room& room, std::uint64_t seed, double rate_hz) {
  Walk walk;
  walk.plan_ = room.walk;
  walk.rate_hz_ = rate_hz;
  const Error blocked{ErrorCode::kDegenerate,
                      "no walk round the middle of the room keeps clear of the furniture"};
  if (room.walk.route.empty()) {
    std::optional<std::vector<double>> radii = PlanRadii(room);
    if (!radii) return blocked;
    SmoothCircularly(*radii, 12);
    for (int d = 0; d < kDirections; ++d)
      walk.control_.push_back(OnLoop(room.walk, d, (*radii)[static_cast<std::size_t>(d)]));
  }
  for (const RoutePoint& point : room.walk.route) {
    walk.control_.push_back(point.stand);
    walk.targets_.push_back(point.look_at);
  }
  walk.MeasureLength();
  const double step = static_cast<double>(walk.Spans()) / kLengthSteps;
  for (int i = 0; i < kLengthSteps; i += 4) {
    if (Clearance(room, walk.OnSpline(walk.control_, i * step)) < kClearanceM) return blocked;
  }
  Random random({.seed = seed, .object = 0x57414c});
  const auto waves = [&](double amplitude, double low_hz, double high_hz, int count) {
    std::vector<Wave> sum;
    for (int i = 0; i < count; ++i) {
      sum.push_back({amplitude * random.Uniform(0.6, 1.0) / std::sqrt(static_cast<double>(count)),
                     random.Uniform(low_hz, high_hz), random.Uniform(0, 2 * std::numbers::pi)});
    }
    return sum;
  };
  const double step_hz = random.Uniform(1.55, 1.8);
  walk.yaw_ = waves(0.55 * kRadPerDeg, 0.3, 1.6, 4);
  walk.pitch_ = waves(0.45 * kRadPerDeg, 0.3, 1.9, 4);
  walk.roll_ = waves(0.7 * kRadPerDeg, 0.2, 1.2, 4);
  walk.across_ = {{0.014, step_hz / 2, random.Uniform(0, 2 * std::numbers::pi)}};
  walk.up_ = {{0.010, step_hz, random.Uniform(0, 2 * std::numbers::pi)},
              {0.02, 0.21, random.Uniform(0, 2 * std::numbers::pi)}};
  walk.pace_ = waves(0.05, 0.1, 0.3, 2);
  walk.gaze_x_ = waves(0.45, 0.06, 0.14, 2);
  walk.gaze_y_ = waves(0.45, 0.06, 0.14, 2);
  walk.gaze_z_ = waves(0.16, 0.05, 0.12, 2);
  return walk;
}

Vector2d Walk::OnSpline(const std::vector<Vector2d>& control, double parameter) const {
  return SplineAt(control, parameter, !plan_.once);
}

double Walk::Sum(const std::vector<Wave>& waves, double t_s) const {
  double sum = 0;
  for (const Wave& wave : waves)
    sum += wave.amplitude * std::sin(2 * std::numbers::pi * wave.frequency_hz * t_s + wave.phase);
  return sum;
}

double Walk::Shake(double t_s) const {
  for (const auto& [first, last] : plan_.shaken_frames) {
    const double from = first / rate_hz_, to = last / rate_hz_;
    if (t_s > from && t_s < to) {
      const double s = std::sin(std::numbers::pi * (t_s - from) / (to - from));
      return s * s;
    }
  }
  return 0;
}

double Walk::ExposureSeconds(int frame) const {
  const double shake = Shake(frame / rate_hz_);
  return plan_.exposure_s + shake * (0.9 / rate_hz_ - plan_.exposure_s);
}

void Walk::MeasureLength() {
  length_.assign(1, 0.0);
  for (int i = 1; i <= kLengthSteps; ++i) {
    const double scale = static_cast<double>(Spans()) / kLengthSteps;
    length_.push_back(length_.back() +
                      (OnSpline(control_, i * scale) - OnSpline(control_, (i - 1) * scale)).norm());
  }
}

double Walk::ParameterAt(double t_s) const {
  // The integral of the pace: its waves only shift the distance walked.
  double distance = plan_.speed_m_s * t_s + plan_.speed_m_s * (Sum(pace_, t_s) - Sum(pace_, 0)) * 2;
  if (plan_.once) {
    distance = std::clamp(plan_.start_m + distance, 0.0, length_.back());
  } else {
    distance = std::fmod(distance, length_.back());
    if (distance < 0) distance += length_.back();
  }
  const auto next = std::upper_bound(length_.begin(), length_.end(), distance);
  const auto i = std::clamp<std::ptrdiff_t>(next - length_.begin() - 1, 0, kLengthSteps - 1);
  const auto index = static_cast<std::size_t>(i);
  const double share =
      (distance - length_[index]) / std::max(1e-12, length_[index + 1] - length_[index]);
  return (static_cast<double>(i) + share) * static_cast<double>(Spans()) / kLengthSteps;
}

Vector2d Walk::Position(double t_s) const { return OnSpline(control_, ParameterAt(t_s)); }

Eigen::Isometry3d Walk::RoomFromCam(double t_s) const {
  const double parameter = ParameterAt(t_s);
  const Vector2d stand = OnSpline(control_, parameter);
  const Vector2d focus = targets_.empty() ? plan_.focus : OnSpline(targets_, parameter);
  const Vector2d to_focus = (focus - stand).normalized();
  const Vector2d side(-to_focus.y(), to_focus.x());
  const double sway = plan_.sway * Sum(across_, t_s);
  const Vector3d eye(stand.x() + sway * side.x(), stand.y() + sway * side.y(),
                     plan_.eye_height_m + plan_.sway * Sum(up_, t_s));
  const Vector3d target(focus.x() + Sum(gaze_x_, t_s), focus.y() + Sum(gaze_y_, t_s),
                        plan_.focus_height_m + Sum(gaze_z_, t_s));
  const Vector3d gaze = target - eye;
  const double shake = Shake(t_s);
  const double yaw = std::atan2(gaze.y(), gaze.x()) + plan_.gaze_offset_rad +
                     plan_.sway * Sum(yaw_, t_s) +
                     shake * 6 * kRadPerDeg * std::sin(2 * std::numbers::pi * 1.9 * t_s);
  const double pitch = std::atan2(gaze.z(), gaze.head<2>().norm()) + plan_.sway * Sum(pitch_, t_s) +
                       shake * 3 * kRadPerDeg * std::sin(2 * std::numbers::pi * 2.6 * t_s + 1);
  const Vector3d forward(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch),
                         std::sin(pitch));
  const Vector3d right = forward.cross(Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << right, forward.cross(right), forward;
  pose.linear() =
      pose.linear() *
      Eigen::AngleAxisd(plan_.sway * Sum(roll_, t_s), Vector3d::UnitZ()).toRotationMatrix();
  pose.translation() = eye;
  return pose;
}

}  // namespace plumbline
