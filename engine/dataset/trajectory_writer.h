// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/result.h"
#include "engine/sensor/pose_estimate.h"

namespace plumbline {

/// A pose as it goes into a file.
struct WrittenPose {
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_sensor = Eigen::Isometry3d::Identity();
  PoseCovariance covariance = PoseCovariance::Zero();  ///< As of PosePerturbation.
};

/// Writes TUM rows `t tx ty tz qx qy qz qw` below a first line that names the frames.
/// @param frames  world_from_body or world_from_cam. Errors: kIo.
Status WriteTrajectory(const std::filesystem::path& file, std::string_view frames,
                       std::span<const WrittenPose> poses);

/// T.covariance.csv of a trajectory T.txt.
std::filesystem::path CovarianceFileOf(const std::filesystem::path& trajectory);

/// Writes rows of a stamp and the 36 numbers of the covariance, row by row, below a first line that
/// states their order and frame. Errors: kIo.
Status WriteCovariances(const std::filesystem::path& file, std::string_view frames,
                        std::span<const WrittenPose> poses);

struct StampedCovariance {
  std::int64_t stamp_ns = 0;
  PoseCovariance covariance = PoseCovariance::Zero();
};

struct Covariances {
  bool of_body = false;  ///< The first line says "world_from_body": of the body's poses.
  /// The first line says "independent": no error is shared by two poses. Otherwise they drift, as a
  /// filter's do.
  bool independent = false;
  std::vector<StampedCovariance> rows;  ///< By strictly rising stamp.
  std::vector<std::string> warnings;    ///< What was odd, one sentence a kind.
};

/// Reads what WriteCovariances wrote. Rows that are incomplete are left out with a warning. Errors:
/// kNotFound, kIo, kCorrupt (no usable row).
Result<Covariances> ReadCovariances(const std::filesystem::path& file);

}  // namespace plumbline
