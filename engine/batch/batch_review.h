// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/snapshot/batch_view.h"

namespace plumbline {

/// What a batch says: means with intervals, responses to what is swept, differences of recipes to
/// the first one, worst runs. Failed and lost runs count as having found nothing.
BatchView ReviewBatch(BatchTable table);

/// Whether figures got worse: runs are paired by sequence, recipe, point and seed, and each figure
/// of each recipe is tested (one-sided sign flips, Holm over all of them, 5 %).
/// @param figures  Names; empty: failed, found, spurious, translation, rotation.
/// Errors: kInvalidInput where no run has a counterpart, or a figure cannot be better or worse.
Result<BatchGate> GateBatch(const BatchTable& now, const BatchTable& baseline,
                            const std::vector<std::string>& figures);

/// How often each cause is the reason for a miss, by recipe.
std::vector<std::map<std::string, int>> CausesByRecipe(const BatchTable& table);

}  // namespace plumbline
