// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/runtime/graph_process.h"

namespace plumbline {

/// A graph that is mapping on this machine, and the run file that its recorder writes.
struct RunningGraph {
  GraphChoice graph;
  std::filesystem::path run;
};

/// Whether this is the folder that `plumbline up` told, or the graph.json in it.
bool NamesGraph(const std::filesystem::path& place);

/// Errors: kInvalidInput for a graph that was not started.
Status CheckStarted(const GraphPlan& plan, const std::string& name);

/// Whether its recorder writes on this machine, so that its run file can be looked at.
bool RecordsHere(const GraphPlan& plan);

/// Errors: of ReadGraph and as above; kUnsupported for one that is recorded on another machine;
/// kNotFound for one that has ended, or whose run has not begun yet.
Result<RunningGraph> FindRunningGraph(const std::filesystem::path& place, const std::string& as);

/// Where `plumbline up` makes the folders of its graphs.
std::filesystem::path PlaceOfGraphs();
inline constexpr const char* kGraphFolderPrefix = "plumbline-";

/// Those in there whose run has begun and is written now, by name.
std::vector<RunningGraph> GraphsOfThisMachine();

}  // namespace plumbline
