// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/snapshot/truths_view.h"

namespace plumbline {

/// How many of the true instances that showed so much are in the map.
struct ShownBin {
  double from = 0;  ///< At least; less than the next bin's.
  int truths = 0, found = 0;
};

/// The true instances of a run by how much they showed: a map that misses what hardly showed is
/// another than one that misses what stood before the camera.
struct ShownTruths {
  std::vector<ShownBin> by_frames;  ///< Frames in which an instance was seen (kSeenShare).
  std::vector<ShownBin> by_pixels;  ///< Most pixels of it that showed in one frame.
};
ShownTruths ShownTruthsOf(const TruthsView& truths);

/// `shown` of `plumbline evaluate --json`.
nlohmann::json ShownTruthsToJson(const ShownTruths& shown);

}  // namespace plumbline
