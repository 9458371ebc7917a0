// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "engine/base/progress.h"
#include "engine/mapping/mapper_options.h"
#include "engine/models/model_database.h"
#include "engine/process/snapshot_source.h"
#include "engine/recording/run_header.h"

namespace plumbline {

struct RunChoice {
  std::filesystem::path run;
  std::filesystem::path sequence, models;  ///< Empty: where the run says that they are.
};

/// The models that the run was made with. Errors: kNotFound; kInvalidInput where the folder holds
/// other models than the run names.
Result<std::shared_ptr<const ModelDatabase>> LoadModelsOfRun(const RunChoice& choice,
                                                             const RunHeader& header);

/// What CreateEdgeDetector takes, from what an edge detector said of itself ("kind file hash").
std::string EdgeChoice(const std::string& description);

/// Gives the frames of a run file; images and maps are computed again from the sequence and the
/// models that the run was made from. Without the sequence its thumbnails stand in for the images.
/// Errors: one sentence that names the file.
Result<std::unique_ptr<SnapshotSource>> OpenRunSource(const RunChoice& choice,
                                                      const WorkContext& work);

}  // namespace plumbline
