// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include <nlohmann/json.hpp>

#include "app/verbs/console_work.h"
#include "app/verbs/graph_arguments.h"
#include "app/verbs/pipeline_arguments.h"
#include "app/verbs/verb.h"
#include "engine/base/files.h"
#include "engine/base/timer.h"
#include "engine/nodes/graph_runner.h"
#include "engine/recording/run_file.h"

namespace plumbline {
namespace {

struct UpArguments {
  PipelineArguments pipeline;
  std::string graph, out, json, folder;
  bool resume = false;
};

/// A new folder that this user alone can enter, with a name short enough for sockets.
Result<std::filesystem::path> NewGraphFolder() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  std::error_code error;
  std::filesystem::path place = std::filesystem::temp_directory_path(error);
  if (runtime != nullptr && std::filesystem::is_directory(runtime, error)) place = runtime;
  std::string name = (place / "plumbline-XXXXXX").string();
  if (::mkdtemp(name.data()) != nullptr) return std::filesystem::path(name);
  return Error{ErrorCode::kIo,
               "cannot make a folder in '" + place.string() + "'; name another with --folder"};
}

Result<std::filesystem::path> GraphFolder(const std::string& wanted) {
  if (wanted.empty()) return NewGraphFolder();
  std::error_code error;
  std::filesystem::path folder = std::filesystem::absolute(wanted);
  if (std::filesystem::exists(folder, error)) {
    if (std::filesystem::is_directory(folder, error) && std::filesystem::is_empty(folder, error))
      return folder;
    return Error{ErrorCode::kInvalidInput,
                 "'" + wanted + "' is there already; --folder names a new or an empty one"};
  }
  std::filesystem::create_directories(folder, error);
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all, error);
  if (!error) return folder;
  return Error{ErrorCode::kIo, "cannot make the folder '" + wanted + "': " + error.message()};
}

int FramesRecorded(const std::filesystem::path& run) {
  const auto reader = RunReader::Open(run);
  if (!reader.ok()) return 0;
  const Result<int> frames = (*reader)->NumFrames();
  return frames.ok() ? *frames : 0;
}

/// Poses of the filter come from a node of its own, and others do not.
Status CheckPoses(const GraphPlan& plan, const RunRecipe& recipe) {
  const GraphNode* mapper = plan.FirstOf(NodeKind::kMapper);
  const bool found = mapper != nullptr && !mapper->poses.empty();
  if (recipe.poses.source == PoseSource::kVio && !found) {
    return Error{ErrorCode::kInvalidInput,
                 "this graph has nobody who finds poses: --poses vio needs a node of kind vio, as "
                 "the graph paper_vio has it"};
  }
  if (recipe.poses.source != PoseSource::kVio && found) {
    return Error{ErrorCode::kInvalidInput,
                 "in this graph the node '" + mapper->poses +
                     "' finds poses; say --poses vio, or choose a graph without it (paper)"};
  }
  return {};
}

Status Up(UpArguments& arguments) {
  if (Status status = arguments.pipeline.Finish(); !status.ok()) return status;
  Result<GraphPlan> plan = GraphNamed(arguments.graph);
  if (!plan.ok()) return plan.error();
  if (Status status = CheckPoses(*plan, arguments.pipeline.recipe); !status.ok()) return status;
  if (arguments.resume && arguments.pipeline.recipe.live_speed)
    return Error{ErrorCode::kInvalidInput, "--live cannot go with --resume"};
  const Result<std::filesystem::path> program = ThisProgram();
  if (!program.ok()) return program.error();
  const Result<std::filesystem::path> folder = GraphFolder(arguments.folder);
  if (!folder.ok()) return folder.error();
  plan->recipe = arguments.pipeline.recipe;
  plan->out = std::filesystem::absolute(arguments.out);
  plan->resume = arguments.resume;
  if (Status status = ResolveGraph(*folder, *plan); !status.ok()) return status;
  GraphRunOptions options;
  options.program = *program;
  options.graph_file = *folder / "graph.json";
  if (Status status = WriteJson(options.graph_file, GraphToJson(*plan)); !status.ok())
    return status;
  std::fprintf(stderr, "%zu nodes; 'plumbline graph %s' shows them\n", plan->nodes.size(),
               folder->c_str());
  options.tell = [](const std::string& line) { std::fprintf(stderr, "%s\n", line.c_str()); };
  ConsoleWork console;
  const WorkContext work = console.context();
  const Stopwatch watch;
  const Result<GraphRunEnd> end = RunGraph(*plan, options, work);
  const double seconds = watch.Milliseconds() / 1000;
  // What a node that failed has said is kept.
  if (arguments.folder.empty() && (end.ok() || console.interrupted())) {
    std::error_code ignored;
    std::filesystem::remove_all(*folder, ignored);
  }
  if (console.interrupted()) {
    return Error{ErrorCode::kCancelled,
                 "stopped; '" + arguments.out + "' keeps what was done, --resume goes on with it"};
  }
  if (!end.ok()) return end.error();
  const int frames = FramesRecorded(plan->out);
  int restarts = 0;
  nlohmann::json json = {{"frames", frames},
                         {"seconds", seconds},
                         {"fps", frames / seconds},
                         {"restarts", nlohmann::json::object()}};
  for (const auto& [name, count] : end->restarts) {
    json["restarts"][name] = count;
    restarts += count;
  }
  if (arguments.json != "-") {
    std::printf("%d frames in %.1f s, %.1f frames/s, in %zu processes", frames, seconds,
                frames / seconds, plan->nodes.size());
    if (restarts > 0) std::printf(", %d started again", restarts);
    std::printf("; wrote %s\n", arguments.out.c_str());
  }
  return arguments.json.empty() ? Status() : WriteJsonResult(arguments.json, json);
}

}  // namespace

void AddUpVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<UpArguments>();
  CLI::App* verb = app.add_subcommand(
      "up", "Map a sequence with modules as processes of their own, as a graph says");
  verb->add_option("graph", arguments->graph,
                   "GRAPH.json, or paper: player, edges, detector, mapper and recorder; paper_vio: "
                   "also a node that finds poses (--poses vio)")
      ->required();
  verb->add_option("sequence", arguments->pipeline.recipe.sequence, "Folder of the sequence")
      ->required();
  verb->add_option("--out", arguments->out, "Run file to write (.plb)")->required();
  arguments->pipeline.AddTo(*verb);
  arguments->pipeline.AddLiveTo(*verb);
  verb->add_flag("--resume", arguments->resume, "Resume the run in --out, if it exists");
  verb->add_option(
      "--folder", arguments->folder,
      "Where sockets and logs lie; kept (default: a new one, removed if all went well)");
  verb->add_option("--json", arguments->json, "Write the result here; - for standard output");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Up(*arguments); }; });
}

}  // namespace plumbline
