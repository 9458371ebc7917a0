// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "engine/runtime/snapshot_source.h"

namespace plumbline {

struct FakeSourceOptions {
  int num_frames = 120;
  int width = 480, height = 250;
  int particles = 200;
  int stride = 1;                  ///< Maps every so many frames.
  int milliseconds_per_frame = 0;  ///< How long Next takes.
  int fail_at_frame = -1;          ///< Next fails there.
  int throw_at_frame = -1;         ///< Next throws there.
  bool recorded = false;           ///< All frames are past ones.
  int live_passes_over = 0;        ///< Played by the clock: so many frames between two; 0: not.
};

/// Makes up frames as a mapper could leave them: a camera that walks around a table with chairs,
/// objects that are born, confirmed and withdrawn, particles that contract. For tests of the window
/// and its process; no engine behind it.
std::unique_ptr<SnapshotSource> MakeFakeSource(const FakeSourceOptions& options);

}  // namespace plumbline
