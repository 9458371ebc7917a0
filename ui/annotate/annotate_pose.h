// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <numbers>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/geometry/gravity.h"
#include "engine/snapshot/annotation_snapshot.h"

namespace plumbline {

inline constexpr double kDegreesPerRadian = 180 / std::numbers::pi;

/// A pose as people read it, in the level frame.
struct LevelPose {
  double x = 0, y = 0, z = 0;  ///< Of the origin [m]; z is the height above the floor.
  double azimuth_rad = 0, tilt_rad = 0;
};

inline LevelPose ReadPose(const AnnotationSnapshot& snapshot,
                          const Eigen::Isometry3d& scan_from_object) {
  const Eigen::Isometry3d pose = snapshot.level_from_scan * scan_from_object;
  const UprightFrame level(Eigen::Vector3d(0, 0, -1));
  return {pose.translation().x(), pose.translation().y(), pose.translation().z(),
          level.Azimuth(pose.linear()), level.Tilt(pose.linear())};
}

inline Eigen::Vector3d UpInScan(const AnnotationSnapshot& snapshot) {
  return snapshot.level_from_scan.linear().row(2).transpose();
}

/// Moved by metres along the axes of the level frame.
inline Eigen::Isometry3d Moved(const AnnotationSnapshot& snapshot, Eigen::Isometry3d pose,
                               const Eigen::Vector3d& by_in_level) {
  pose.translation() += snapshot.level_from_scan.linear().transpose() * by_in_level;
  return pose;
}

/// Turned about an axis of the level frame through the object's origin.
inline Eigen::Isometry3d Turned(const AnnotationSnapshot& snapshot, Eigen::Isometry3d pose,
                                const Eigen::Vector3d& axis_in_level, double angle_rad) {
  const Eigen::Vector3d axis = snapshot.level_from_scan.linear().transpose() * axis_in_level;
  const Eigen::AngleAxisd turn(angle_rad, axis.normalized());
  pose.linear() = turn.toRotationMatrix() * pose.linear();
  return pose;
}

/// The pose without its tilt, about its origin.
inline Eigen::Isometry3d Upright(const AnnotationSnapshot& snapshot, Eigen::Isometry3d pose) {
  const UprightFrame frame(-UpInScan(snapshot));
  pose.linear() = frame.WorldFromObjectRotation(frame.Azimuth(pose.linear()));
  return pose;
}

}  // namespace plumbline
