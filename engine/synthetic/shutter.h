// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Geometry>

#include "engine/sensor/camera.h"

namespace plumbline {

/// Where the camera is while one picture is taken. With a rolling shutter each row is exposed
/// around a time of its own.
class Shutter {
 public:
  /// @param room_from_cam  Of the moving camera, by time [s]. Asked from several threads.
  /// @param stamp_s        The middle of the middle row's exposure.
  Shutter(std::function<Eigen::Isometry3d(double t_s)> room_from_cam, double stamp_s,
          double exposure_s, const Camera& camera);
  /// Of a camera that holds still, so that a pose serves wherever a shutter is asked for.
  Shutter(const Eigen::Isometry3d& room_from_cam);

  bool rolling() const { return camera_.rolling_shutter_s != 0; }
  /// room_from_cam at the picture's stamp.
  const Eigen::Isometry3d& middle() const { return middle_; }
  /// Of the middle of a row's exposure [s]; 0 for a camera that holds still.
  double TimeOf(double row_px) const { return stamp_s_ + camera_.RowDelay(row_px); }
  double exposure_s() const { return exposure_s_; }
  /// At the middle of a row's exposure.
  Eigen::Isometry3d RoomFromCam(double row_px) const;
  /// 24 poses, evenly spread over a row's exposure.
  std::vector<Eigen::Isometry3d> Exposure(double row_px) const;
  /// Of the row in which the camera sees a point: a fixed point, found to some 1e-3 px where the
  /// picture moves by less than a tenth of its height during the read-out. `middle()` for a point
  /// that is not in front of the camera.
  Eigen::Isometry3d Seeing(const Eigen::Vector3d& point_in_room) const;

 private:
  std::function<Eigen::Isometry3d(double t_s)> room_from_cam_;
  double stamp_s_ = 0, exposure_s_ = 0;
  Camera camera_;
  Eigen::Isometry3d middle_;
};

}  // namespace plumbline
