// SPDX-License-Identifier: Apache-2.0
#include "engine/runtime/running_graph.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "engine/base/file_lock.h"
#include "engine/nodes/our_nodes.h"

namespace plumbline {
namespace {

namespace fs = std::filesystem;

constexpr const char* kGraphFile = "graph.json";

fs::path FileOf(const fs::path& place) {
  std::error_code ignored;
  return fs::is_directory(place, ignored) ? place / kGraphFile : place;
}

}  // namespace

bool NamesGraph(const fs::path& place) {
  std::error_code ignored;
  const fs::path file = FileOf(place);
  return file.filename() == kGraphFile && fs::is_regular_file(file, ignored);
}

Status CheckStarted(const GraphPlan& plan, const std::string& name) {
  if (!plan.folder.empty()) return {};
  return Error{
      ErrorCode::kInvalidInput,
      "'" + name + "' is not running; name the folder that 'plumbline up' told when it started"};
}

bool RecordsHere(const GraphPlan& plan) {
  std::error_code ignored;
  const GraphNode* recorder = plan.FirstOf(NodeKind::kRecorder);
  return recorder != nullptr && recorder->endpoint.starts_with("ipc://") &&
         fs::is_directory(plan.folder, ignored);
}

Result<RunningGraph> FindRunningGraph(const fs::path& place, const std::string& as) {
  auto plan = ReadGraph(FileOf(place));
  if (!plan.ok()) return plan.error();
  if (Status status = CheckStarted(*plan, place.string()); !status.ok()) return status.error();
  if (!RecordsHere(*plan)) {
    return Error{ErrorCode::kUnsupported,
                 "the graph of '" + place.string() +
                     "' is recorded on another machine; 'plumbline gui --attach " + place.string() +
                     "' keeps a copy of its run and shows that"};
  }
  std::error_code ignored;
  if (!fs::exists(plan->folder / kRunBegun, ignored) || !fs::exists(plan->out, ignored)) {
    return Error{ErrorCode::kNotFound, "the graph in '" + plan->folder.string() +
                                           "' has not begun its run yet; open it again in a while"};
  }
  const fs::path run = plan->out;
  return RunningGraph{{std::move(plan).value(), place.string(), as}, run};
}

fs::path PlaceOfGraphs() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code error;
  if (runtime != nullptr && fs::is_directory(runtime, error)) return runtime;
  return fs::temp_directory_path(error);
}

std::vector<RunningGraph> GraphsOfThisMachine() {
  std::vector<RunningGraph> graphs;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(PlaceOfGraphs(), error)) {
    const fs::path& folder = entry.path();
    if (!folder.filename().string().starts_with(kGraphFolderPrefix) || !NamesGraph(folder))
      continue;
    auto graph = FindRunningGraph(folder, kViewerName);
    // A graph that was killed leaves its folder behind, and nobody writes its run.
    if (graph.ok() && FileLock::IsHeld(graph->run)) graphs.push_back(std::move(graph).value());
  }
  std::sort(graphs.begin(), graphs.end(), [](const RunningGraph& a, const RunningGraph& b) {
    return a.graph.name < b.graph.name;
  });
  return graphs;
}

}  // namespace plumbline
