// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "engine/base/progress.h"
#include "engine/recording/run_inputs.h"
#include "engine/runtime/snapshot_source.h"

namespace plumbline {

/// Gives the frames of a run file; images and maps are computed again from the sequence and the
/// models that the run was made from. Without the sequence its thumbnails stand in for the images.
/// Errors: one sentence that names the file.
Result<std::unique_ptr<SnapshotSource>> OpenRunSource(const RunChoice& choice,
                                                      const WorkContext& work);

}  // namespace plumbline
