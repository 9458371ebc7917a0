// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "engine/base/result.h"

namespace plumbline {

struct StampedPose {
  std::int64_t stamp_ns = 0;
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
};

/// Camera poses by strictly rising stamp.
struct Trajectory {
  std::vector<StampedPose> poses;
  std::vector<std::string> warnings;  ///< Rows that were left out and why, one sentence a kind.

  /// The pose nearest to the stamp, at most `within_ns` away.
  std::optional<Eigen::Isometry3d> Nearest(std::int64_t stamp_ns, std::int64_t within_ns) const;
};

/// Reads a TUM trajectory (`t tx ty tz qx qy qz qw`). Rows are world_from_cam; where the first line
/// says
/// `# world_from_body` they are the body's and `body_from_cam` is applied. Rows that are
/// incomplete, not finite or whose quaternion is not of unit length (1 %) are left out with a
/// warning; of rows with one stamp the first counts. Errors: kNotFound, kIo, kCorrupt (no usable
/// row), kInvalidInput (body poses without `body_from_cam`).
Result<Trajectory> ReadTrajectory(const std::filesystem::path& file,
                                  const std::optional<Eigen::Isometry3d>& body_from_cam);

}  // namespace plumbline
