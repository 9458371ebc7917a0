// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "engine/base/result.h"
#include "engine/models/model_database.h"
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

/// The sequence that the run was made from, with the poses that it was made with. A trajectory that
/// is gone is replaced by the poses of the data set, with a warning: that is for looking only.
/// Errors: as of OpenSequence.
Result<std::shared_ptr<const Sequence>> OpenSequenceOfRun(const RunChoice& choice,
                                                          const RunHeader& header);

/// The recipe of the run, with the folders that `choice` names in place of its own. What goes on
/// from a live run, or looks at it again, is not live.
RunRecipe RecipeOf(const RunChoice& choice, const RunHeader& header);

}  // namespace plumbline
