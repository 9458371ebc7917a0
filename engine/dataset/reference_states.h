// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/result.h"

namespace plumbline {

/// Where the body really was at one time, and what the IMU added.
struct ReferenceState {
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_body = Eigen::Isometry3d::Identity();
  Eigen::Vector3d velocity_in_world{0, 0, 0};  ///< [m/s]
  Eigen::Vector3d gyro_bias{0, 0, 0};          ///< [rad/s]
  Eigen::Vector3d accel_bias{0, 0, 0};         ///< [m/s^2]
};

struct ReferenceStates {
  std::vector<ReferenceState> states;  ///< By strictly rising stamp.
  std::vector<std::string> warnings;   ///< What was odd, one sentence a kind.
};

/// Reads groundtruth.csv: rows
/// `t,px,py,pz,qx,qy,qz,qw,vx,vy,vz,bgx,bgy,bgz,bax,bay,baz`. Rows whose quaternion is not of unit
/// length (1 %) are left out with a warning. Errors: kNotFound, kIo, kCorrupt (no usable row).
Result<ReferenceStates> ReadReferenceStates(const std::filesystem::path& file);

}  // namespace plumbline
