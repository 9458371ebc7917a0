// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/synthetic/room.h"

namespace plumbline {

/// Distance from a point to the nearest wall or obstacle [m], negative inside one.
double Clearance(const Room& room, const Eigen::Vector2d& point);

/// A hand-held camera carried along a room's walk plan, round its focus or along its route: a
/// smooth path, closed unless the route is gone once, at a calm pace, with the sway of steps and
/// the tremor of hands. A function of continuous time.
class Walk {
 public:
  /// Finds a loop round the focus that keeps `kClearanceM` from everything, or checks that the
  /// route does. Errors: kDegenerate where there is none, or it does not.
  static Result<Walk> Plan(const Room& room, std::uint64_t seed, double rate_hz);

  /// Pose of the camera (x right, y down, z forward) at time `t_s` >= 0.
  Eigen::Isometry3d RoomFromCam(double t_s) const;
  /// Length of the exposure of a frame [s].
  double ExposureSeconds(int frame) const;
  /// Where the walker stands [m].
  Eigen::Vector2d Position(double t_s) const;
  /// Of once round, or of the whole route [m].
  double Length() const { return length_.back(); }

  static constexpr double kClearanceM = 0.32;

 private:
  struct Wave {
    double amplitude, frequency_hz, phase;
  };
  double Sum(const std::vector<Wave>& waves, double t_s) const;
  double Shake(double t_s) const;
  /// Where the walker is on the way at a time, as a parameter of the splines.
  double ParameterAt(double t_s) const;
  void MeasureLength();
  Eigen::Vector2d OnSpline(const std::vector<Eigen::Vector2d>& control, double parameter) const;
  /// Pieces of the spline.
  int Spans() const { return static_cast<int>(control_.size()) - (plan_.once ? 1 : 0); }

  WalkPlan plan_;
  double rate_hz_ = 30;
  /// Control points of uniform cubic B-splines, from the start on: of the way, and (of a route) of
  /// what is looked at.
  std::vector<Eigen::Vector2d> control_, targets_;
  std::vector<double> length_;  ///< From the start to evenly spaced parameters [m].
  std::vector<Wave> yaw_, pitch_, roll_, across_, up_, pace_, gaze_x_, gaze_y_, gaze_z_;
};

}  // namespace plumbline
