// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "engine/base/progress.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/runtime/snapshot_source.h"

namespace plumbline {

struct MappingChoice {
  RunRecipe recipe;
  std::filesystem::path out;  ///< Run file to leave; empty: a temporary one, removed at the end.
  std::string program_version;
};

/// Maps a sequence as far as it is asked to, and records into a run file, from which it gives past
/// frames back. Errors: one sentence that names the file.
Result<std::unique_ptr<SnapshotSource>> OpenMappingSource(const MappingChoice& choice,
                                                          const WorkContext& work);

}  // namespace plumbline
