// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/shutter.h"

#include <algorithm>
#include <utility>

namespace plumbline {

Shutter::Shutter(std::function<Eigen::Isometry3d(double t_s)> room_from_cam, double stamp_s,
                 double exposure_s, const Camera& camera)
    : room_from_cam_(std::move(room_from_cam)),
      stamp_s_(stamp_s),
      exposure_s_(exposure_s),
      camera_(camera),
      middle_(room_from_cam_(stamp_s)) {}

Shutter::Shutter(const Eigen::Isometry3d& room_from_cam)
    : room_from_cam_([room_from_cam](double) { return room_from_cam; }), middle_(room_from_cam) {}

Eigen::Isometry3d Shutter::RoomFromCam(double row_px) const {
  return rolling() ? room_from_cam_(stamp_s_ + camera_.RowDelay(row_px)) : middle_;
}

std::vector<Eigen::Isometry3d> Shutter::Exposure(double row_px) const {
  constexpr int kPoses = 24;
  const double middle_s = stamp_s_ + camera_.RowDelay(row_px);
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < kPoses; ++i)
    poses.push_back(room_from_cam_(middle_s + exposure_s_ * ((i + 0.5) / kPoses - 0.5)));
  return poses;
}

Eigen::Isometry3d Shutter::Seeing(const Eigen::Vector3d& point_in_room) const {
  constexpr int kRounds = 3;
  Eigen::Isometry3d pose = middle_;
  for (int round = 0; rolling() && round < kRounds; ++round) {
    const Eigen::Vector3d in_cam = pose.inverse() * point_in_room;
    if (!(in_cam.z() > 0)) return middle_;
    const double row = camera_.pinhole.Project(in_cam).y();
    pose = RoomFromCam(std::clamp(row, 0.0, camera_.pinhole.height - 1.0));
  }
  return pose;
}

}  // namespace plumbline
