// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "engine/evaluation/belief_report.h"
#include "engine/snapshot/object_history.h"
#include "engine/snapshot/run_history.h"

namespace plumbline {

/// The beliefs about confirmed objects that have a true instance within kPairReach_m, in all frames
/// in which they were updated.
RunReliability ReliabilityOf(const RunHistory& history);

/// The same in the last frame alone, updated or not: what the run ends with.
RunReliability ReliabilityAtEnd(const RunHistory& history);

/// Which objects of the last frame, confirmed or not, are there, against how surely they are
/// believed to be: 1 / (1 + exp(-log_evidence)).
PrecisionRecall ConfirmationOf(const RunHistory& history, int truths);

/// All of the above, over all objects and for each confirmed one: `belief` of `plumbline evaluate
/// --json`.
nlohmann::json BeliefToJson(const RunHistory& history, int truths);

}  // namespace plumbline
