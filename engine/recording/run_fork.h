// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "engine/base/progress.h"
#include "engine/pipeline/mapping_pipeline.h"
#include "engine/recording/run_file.h"
#include "engine/recording/run_inputs.h"

namespace plumbline {

/// The last frame that the run `file` holds. Errors: kNotFound; kInvalidInput where it is empty.
Result<int> LastFrameOf(const std::filesystem::path& file);

/// Copies the past of the run `file`, up to the frame `at`, into `writer`, and
/// lets `pipeline` go on from there.
/// @param seen  Gets every report that is taken over.
/// @return The last frame that was taken over. Errors: of reading and writing; kInvalidInput for a
/// run of another sequence, other models or other frames.
Result<int> TakeOverPast(const std::filesystem::path& file, int at, MappingPipeline& pipeline,
                         RunWriter& writer, const std::function<void(const FrameReport&)>& seen);

/// What a run would have become with other options or another seed from a frame on.
struct ForkChoice {
  RunChoice run;  ///< The run that is forked.
  int at = 0;     ///< The last frame that is taken over.
  MapperOptions options;
  std::uint64_t seed = 0;
  std::filesystem::path out;  ///< The new run file.
  std::string program_version;
  std::optional<PlantedObject> plant = {};  ///< That the mapper is given after `at`.
};

/// Maps the fork to its end with the inputs of the run. Stopped, it leaves what is done.
/// Errors: one sentence that names the file; kCancelled.
Status ForkRun(const ForkChoice& choice, const WorkContext& work);

}  // namespace plumbline
