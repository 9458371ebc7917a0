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

/// A hand-held camera carried round the focus of a room's walk plan: a closed, smooth path at a
/// calm pace, with the sway of steps and the tremor of hands. A function of continuous time.
class Walk {
 public:
  /// Finds a loop that keeps `kClearanceM` from everything. Errors: kDegenerate where there is
  /// none.
  static Result<Walk> Plan(const Room& room, std::uint64_t seed, double rate_hz);

  /// Pose of the camera (x right, y down, z forward) at time `t_s` >= 0.
  Eigen::Isometry3d RoomFromCam(double t_s) const;
  /// Length of the exposure of a frame [s].
  double ExposureSeconds(int frame) const;
  /// Where the walker stands [m].
  Eigen::Vector2d Position(double t_s) const;

  static constexpr double kClearanceM = 0.32;

 private:
  struct Wave {
    double amplitude, frequency_hz, phase;
  };
  double Sum(const std::vector<Wave>& waves, double t_s) const;
  double Shake(double t_s) const;
  Eigen::Vector2d SplineAt(double parameter) const;
  void MeasureLength();

  WalkPlan plan_;
  double rate_hz_ = 30;
  std::vector<Eigen::Vector2d>
      control_;                 ///< Of a closed uniform cubic B-spline, from the start on.
  std::vector<double> length_;  ///< From the start to evenly spaced parameters [m].
  std::vector<Wave> yaw_, pitch_, roll_, across_, up_, pace_, gaze_x_, gaze_y_, gaze_z_;
};

}  // namespace plumbline
