// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "engine/analysis/planted_truth.h"
#include "engine/analysis/run_review.h"

namespace plumbline {

/// Maps the run once more for every instance that it missed although it showed, from before that
/// shows well on and with its true pose as a candidate: is the search to blame, the likelihood, or
/// the evidence for being there? The forks stay in `folder`, as RUN.INSTANCE.plb.
/// @param review  Of the run.
/// @return By the instances' names. Errors: of ForkRun and ReviewRun; kIo for the folder.
Result<std::map<std::string, PlantedTruth>> PlantMissed(const RunChoice& run,
                                                        const std::filesystem::path& ground_truth,
                                                        const RunReview& review,
                                                        const std::filesystem::path& folder);

}  // namespace plumbline
