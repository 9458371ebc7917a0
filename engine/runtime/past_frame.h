// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/base/result.h"
#include "engine/pipeline/frame_pictures.h"
#include "engine/recording/run_file.h"
#include "engine/runtime/snapshot_memory.h"

namespace plumbline {

/// A recorded frame with its pictures made again, the run's small picture where its image is
/// missing; kept in `memory`, and taken from there. Errors: those of RunReader::ReadFrame.
Result<std::shared_ptr<const MapSnapshot>> PastFrame(int position, RunReader& reader,
                                                     FramePictures& pictures,
                                                     SnapshotMemory& memory);

}  // namespace plumbline
