// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace plumbline {

struct FrameEntry {
  std::int64_t stamp_ns = 0;
  std::string file;  ///< Name inside color/; empty without images.
};

/// The frames of a sequence in Plumbline's own layout, by strictly rising stamp.
struct FrameList {
  std::vector<FrameEntry> frames;
  double rate_hz = 0;
  bool has_images = true;
  std::vector<std::string> warnings;
};

/// Lists the frames of `folder`: rows `stamp_s,file` of color.csv if present, else the images of
/// color/ at file number / rate. Where there is no folder color/, the frames are the rows of
/// color.csv or the times of tracks.csv. Without `rate_hz` the rate is that of the median step.
/// Errors: kNotFound (no frames), kCorrupt (no usable row), kInvalidInput (neither rate nor
/// stamps).
Result<FrameList> ListFrames(const std::filesystem::path& folder, std::optional<double> rate_hz);

}  // namespace plumbline
