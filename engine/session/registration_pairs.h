// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "engine/annotation/annotation_document.h"
#include "engine/base/result.h"
#include "engine/registration/sequence_alignment.h"

namespace plumbline {

/// The same points in a scan and in a sequence, as RegisterByPicks takes them.
struct RegistrationPairs {
  std::vector<FramePick> in_frames;
  std::vector<PickedPair> in_world;
};

/// A JSON list of {"in_scan": [x, y, z], "frame": n, "pixel": [u, v]} or {"in_scan", "in_world":
/// [x, y, z]}, in metres (at most kFarthest_m) and pixels. Errors: kNotFound, kIo, kCorrupt;
/// kInvalidInput with the number of the pair, from 1.
Result<RegistrationPairs> ReadRegistrationPairs(const std::filesystem::path& file);

}  // namespace plumbline
