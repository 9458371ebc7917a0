// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/result.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/recording/run_file.h"
#include "engine/smoothing/smoother.h"

namespace plumbline {

/// Puts a smoothed map beside the run, in place of an older one; the run itself stays as it is,
/// whatever ends the program. Errors: kNotFound, kIo, kInvalidInput (somebody is writing the file,
/// or the run has other frames than the map), naming the file.
Status WriteSmoothed(const std::filesystem::path& run, const SmoothedMap& map);

/// Nothing where the run has not been smoothed. Errors: as of RunReader::Open; kCorrupt.
Result<std::optional<SmoothedMap>> ReadSmoothed(const std::filesystem::path& run);

/// Smooths a run that has ended and writes the result beside it. `pipeline` was opened with the
/// recipe of the run and maps nothing meanwhile. Errors: of WriteSmoothed and Smooth; kInvalidInput
/// for a run that has not ended. The run itself stays as it is.
Result<SmoothedMap> SmoothRun(const std::filesystem::path& run, MappingPipeline& pipeline,
                              const WorkContext& work);

}  // namespace plumbline
