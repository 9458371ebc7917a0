// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "engine/base/result.h"

namespace plumbline {

/// Where a tracked point was seen in one image.
struct TrackedPoint {
  std::int64_t id = 0;    ///< Of the track, across images.
  Eigen::Vector2d pixel;  ///< Of the image as recorded, distortion included.
};

/// The tracked points of one image.
struct TrackedImage {
  std::int64_t stamp_ns = 0;
  std::vector<TrackedPoint> points;  ///< In the order of the file.
};

struct FeatureTracks {
  std::vector<TrackedImage> images;   ///< By strictly rising stamp.
  std::vector<std::string> warnings;  ///< What was odd, one sentence a kind.
};

/// Reads tracks.csv: rows `t,id,u,v`. Errors: kNotFound, kIo, kCorrupt (no usable row).
Result<FeatureTracks> ReadTracksFile(const std::filesystem::path& file);

}  // namespace plumbline
