// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/vio/trajectory_correction.h"

namespace plumbline {

/// Where a closed loop moved the poses of the images before it.
struct PastCorrection {
  int image = 0;  ///< At which it became known: poses from here on contain it.
  int epoch = 0;
  YawMove present;       ///< What the filter's poses from here on are moved by, until the next.
  TrajectoryMoves past;  ///< Of the filter's poses before. Empty: let go of, a later one says more.
};

/// The pose of an image as it was told at its time.
struct PoseWhenTold {
  int image = 0;
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  Eigen::Vector3d body_in_world{0, 0, 0};
};

/// @return world_from_cam of an image before `correction.image`, as known then.
/// @param correction  With a past. @param all  By rising image, up to it at least.
Eigen::Isometry3d CorrectedBy(const PastCorrection& correction, std::span<const PastCorrection> all,
                              const PoseWhenTold& told);

}  // namespace plumbline
