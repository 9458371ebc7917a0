// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/snapshot/truths_view.h"

namespace plumbline {

/// What one run made of the true instances of its scene.
struct JudgedRun {
  std::string name;   ///< Of its file, without ".plb".
  std::string scene;  ///< What it was made of: runs of one scene share its instances.
  TruthsView truths;
};

/// The true instances of a scene by its runs.
struct MissedTable {
  struct Row {
    std::string truth, model;
    std::vector<const TruthView*> by_run;  ///< As `runs`; null: that run does not know it.
    int found = 0;                         ///< In how many of them.
  };
  std::string scene;
  std::vector<const JudgedRun*> runs;
  std::vector<Row> rows;  ///< In the order of the first run that knows them.
};

/// One table for each scene, in the order of the runs. They point into `runs`.
std::vector<MissedTable> MissedTables(std::span<const JudgedRun> runs);

/// How many instances were missed for each cause, over all runs; causes that do not occur are not
/// there.
std::map<MissedCause, int> CausesOf(std::span<const JudgedRun> runs);

/// {"scenes": [{"scene", "runs": [{"run", "found", "missed", "causes"}], "truths": [{"id", "model",
/// "found_in", "runs": {NAME: {"found", "why"}}}]}], "causes": {CAUSE: count}}; `why` as of
/// WhyMissedToJson.
nlohmann::json MissedTablesToJson(std::span<const JudgedRun> runs);

}  // namespace plumbline
