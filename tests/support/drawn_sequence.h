// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "tests/support/mapping_scene.h"

namespace plumbline {

struct DrawnSequenceOptions {
  int frames = 60;
  int boxes_until = 1 << 30;  ///< From this frame on nothing is detected.
};

/// What the sequence shows: a table and two chairs.
std::vector<PlacedModel> DrawnObjects();

/// Writes a sequence of 480x360 at 10 Hz in Plumbline's own layout, with perfect edges and boxes
/// and its own models: a camera walks half round a table with two chairs.
void WriteDrawnSequence(const std::filesystem::path& folder, const DrawnSequenceOptions& options);

}  // namespace plumbline
