// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/analysis/frame_difference.h"
#include "engine/analysis/run_review.h"

namespace plumbline {

/// An object of one run beside that of another, in the last frames.
struct ObjectDifference : ObjectPair {
  std::optional<TruthError> error_a, error_b;  ///< Against ground truth, where there is any.
};

/// A true instance that one run lacks, or both.
struct MissedDifference {
  std::string truth;
  std::string why_a, why_b;  ///< TruthView::text; "": that run has it.
};

/// What tells two runs of one sequence apart. It points into both reviews.
struct RunDifference {
  std::vector<std::string> settings;  ///< "alpha: 4 / 6", seed, inputs.
  std::optional<int> first_frame;     ///< The first common frame in which beliefs differ.
  int common_frames = 0;
  std::vector<ObjectDifference> objects;  ///< Confirmed in the last frame of either.
  std::vector<MissedDifference> missed;
  std::vector<StageDifference> stages;
};

/// "alpha: 4 / 6", seed, inputs: what differs in what the runs were made with.
std::vector<std::string> DifferentSettings(const RunHeader& a, const RunHeader& b);

/// "first run, from frame 41: alpha 2.5 -> 4.0": options that changed while a run went on.
std::vector<std::string> ChangesOnTheWay(const char* run, const RunHeader& header,
                                         const std::vector<RunEvent>& events);

/// Objects are paired by PairObjects. Errors: kInvalidInput for runs with
/// different models.
Result<RunDifference> CompareRuns(const RunReview& a, const RunReview& b);

nlohmann::json DifferenceToJson(const RunDifference& difference, const RunReview& a,
                                const RunReview& b);

}  // namespace plumbline
