// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/process/run_review.h"

namespace plumbline {

/// An object of one run beside that of another; one of them may be missing.
struct ObjectDifference {
  const ObjectReport* a = nullptr;
  const ObjectReport* b = nullptr;
  double distance_m = 0, azimuth_rad = 0;      ///< Between their poses; 0 where one is missing.
  std::optional<TruthError> error_a, error_b;  ///< Against ground truth, where there is any.
};

struct StageDifference {
  std::string stage;
  double mean_a_ms = 0,
         mean_b_ms = 0;  ///< Over the frames of each run; 0 where it lacks the stage.
};

/// What tells two runs of one sequence apart. It points into both reviews.
struct RunDifference {
  std::vector<std::string> settings;  ///< "alpha: 4 / 6", seed, inputs.
  std::optional<int> first_frame;     ///< The first common frame in which beliefs differ.
  int common_frames = 0;
  std::vector<ObjectDifference> objects;  ///< Confirmed in the last frame of either.
  std::vector<StageDifference> stages;
};

/// Objects are paired by category, nearest first, within 0.5 m. Errors: kInvalidInput for runs with
/// different models.
Result<RunDifference> CompareRuns(const RunReview& a, const RunReview& b);

nlohmann::json DifferenceToJson(const RunDifference& difference, const RunReview& a,
                                const RunReview& b);

}  // namespace plumbline
