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
  std::string file;  ///< Name inside color/.
};

/// The frames of a sequence in Plumbline's own layout, by strictly rising stamp.
struct FrameList {
  std::vector<FrameEntry> frames;
  double rate_hz = 0;
  std::vector<std::string> warnings;
};

/// Lists the frames of `folder`: rows `stamp_s,file` of color.csv if present, else the images of
/// color/ at file number / rate. Without `rate_hz` the rate is that of the median step of
/// color.csv. Errors: kNotFound (no frames), kCorrupt (no usable row), kInvalidInput (neither rate
/// nor stamps).
Result<FrameList> ListFrames(const std::filesystem::path& folder, std::optional<double> rate_hz);

}  // namespace plumbline
