// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "engine/base/result.h"

namespace plumbline {

/// `plumbline evaluate` of several runs.
struct EvaluateRunsArguments {
  std::vector<std::string> runs;     ///< Run files, and folders of them.
  std::string ground_truth, models;  ///< Empty: those of each run's sequence, and of the run.
  std::vector<std::string> ignored_categories;
  std::string json;
};

/// Prints which run found which true instance, why it missed the others, and how often for which
/// cause. A run that cannot be judged is named and left out.
/// Errors: kNotFound for what is not there; kInvalidInput if no run can be judged.
Status EvaluateRuns(const EvaluateRunsArguments& arguments);

}  // namespace plumbline
