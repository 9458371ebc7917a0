// SPDX-License-Identifier: Apache-2.0
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "app/verbs/console_work.h"
#include "app/verbs/graph_arguments.h"
#include "app/verbs/open_source.h"
#include "app/verbs/pipeline_arguments.h"
#include "app/verbs/verb.h"
#include "app/verbs/window_arguments.h"
#include "app/window/application.h"
#include "engine/nodes/our_nodes.h"
#include "engine/nodes/run_mirror.h"
#include "engine/runtime/run_file_place.h"
#include "engine/runtime/running_graph.h"

namespace plumbline {
namespace {

struct GuiArguments {
  PipelineArguments pipeline;
  WindowArguments window;
  std::string path, sequence, out, compare, attach, as = kViewerName;
  std::optional<int> frame;
  bool demo = false;
  std::string state_file;
  double least_frame_ms = 0;
};

/// What is played live is a sequence, from its first frame on.
Status CheckLiveGui(const GuiArguments& arguments) {
  if (!arguments.pipeline.recipe.live_speed) return {};
  if (arguments.frame)
    return Error{ErrorCode::kInvalidInput,
                 "--live cannot go with --frame: which frames are mapped is up to the clock"};
  if (std::filesystem::path(arguments.path).extension() == ".plb")
    return Error{ErrorCode::kInvalidInput, "--live plays a sequence to the mapper, and '" +
                                               arguments.path +
                                               "' is a run that is mapped already"};
  return {};
}

/// A graph that is mapping, and the run file that shows what it maps.
struct Attached {
  GraphChoice graph;
  std::optional<RunFilePlace> place;  ///< Of a copy; before what writes there.
  std::unique_ptr<RunMirror> mirror;  ///< Null where the graph's own file is at hand.
  std::filesystem::path run;
};

Status CheckAttach(const GuiArguments& arguments) {
  if (!arguments.path.empty())
    return Error{ErrorCode::kInvalidInput,
                 "--attach shows what the graph maps; leave out '" + arguments.path + "'"};
  if (arguments.pipeline.recipe.live_speed)
    return Error{ErrorCode::kInvalidInput,
                 "--live is said to 'plumbline up'; --attach shows what it maps"};
  return {};
}

/// Of a graph of this machine: its run file, once the recorder has begun it.
Result<std::filesystem::path> RunOfGraph(const GraphPlan& plan, const WorkContext& work) {
  std::error_code ignored;
  while (!std::filesystem::exists(plan.folder / kRunBegun, ignored)) {
    if (work.stop.stop_requested()) return Error{ErrorCode::kCancelled, "stopped"};
    if (!std::filesystem::is_directory(plan.folder, ignored))
      return Error{ErrorCode::kNotFound,
                   "the graph in '" + plan.folder.string() + "' has ended before its run began"};
    work.report({"Waiting for the run to begin"});
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return plan.out;
}

Result<std::unique_ptr<Attached>> Attach(const GuiArguments& arguments) {
  if (Status status = CheckAttach(arguments); !status.ok()) return status.error();
  auto plan = GraphNamed(arguments.attach);
  if (!plan.ok()) return plan.error();
  if (Status status = CheckStarted(*plan, arguments.attach); !status.ok()) return status.error();
  auto attached = std::make_unique<Attached>();
  attached->graph = {*plan, arguments.attach, arguments.as};
  ConsoleWork console;
  const WorkContext work = console.context();
  const bool here = RecordsHere(*plan);
  if (here && !arguments.out.empty())
    return Error{ErrorCode::kInvalidInput,
                 "--out keeps a copy of what a graph on another machine maps; this one writes '" +
                     plan->out.string() + "' here"};
  if (here) {
    auto run = RunOfGraph(*plan, work);
    if (!run.ok()) return run.error();
    attached->run = *run;
    return attached;
  }
  auto place = RunFilePlace::Choose(arguments.out);
  if (!place.ok()) return place.error();
  attached->place.emplace(std::move(place).value());
  attached->run = attached->place->path();
  auto mirror = RunMirror::Start(*plan, arguments.as, attached->run, work);
  if (!mirror.ok()) return mirror.error();
  attached->mirror = std::move(mirror).value();
  return attached;
}

Status Gui(GuiArguments& arguments) {
  if (Status status = arguments.pipeline.Finish(); !status.ok()) return status;
  if (Status status = CheckLiveGui(arguments); !status.ok()) return status;
  ApplicationOptions options;
  if (Status status = arguments.window.Apply(options); !status.ok()) return status;
  options.inspect.inputs = {{}, arguments.sequence, arguments.pipeline.recipe.models};
  options.inspect.opener = SourceOpener(
      {arguments.pipeline.recipe, arguments.out, PLUMBLINE_VERSION}, options.inspect.inputs);
  const char* user = std::getenv("USER");
  options.annotation = {"", arguments.pipeline.recipe.models, arguments.sequence,
                        user != nullptr ? user : ""};
  options.path = arguments.path;
  std::unique_ptr<Attached> attached;
  if (!arguments.attach.empty()) {
    auto found = Attach(arguments);
    if (!found.ok()) return found.error();
    attached = std::move(found).value();
    options.path = attached->run.string();
    options.inspect.graph = attached->graph;
  }
  options.compare = arguments.compare;
  options.inspect.program_version = PLUMBLINE_VERSION;
  options.inspect.present = arguments.demo;
  options.start_frame = arguments.frame;
  options.state_file = arguments.state_file;
  options.least_frame_ms = arguments.least_frame_ms;
  auto application = Application::Create(std::move(options));
  if (!application.ok()) return application.error();
  return (*application)->Run();
}

}  // namespace

void AddGuiVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<GuiArguments>();
  CLI::App* verb = app.add_subcommand("gui",
                                      "Open the window: play a sequence through the mapper, or a "
                                      "recorded run; or place models in a "
                                      "scan");
  verb->add_option(
      "path", arguments->path,
      "Folder of a sequence, a run file (.plb), a scan (.ply, .pcd, .obj), an annotation project "
      "(.json), or a folder of scans to annotate; without one the window asks");
  verb->add_option("--frame", arguments->frame, "Frame to show first; the mapper goes up to it");
  verb->add_flag("--demo", arguments->demo,
                 "Full screen, one view after the other with captions, until any key");
  arguments->pipeline.AddTo(*verb);
  arguments->pipeline.AddLiveTo(*verb);
  verb->add_option("--out", arguments->out,
                   "Keep the run that the window maps in this file (.plb)");
  verb->add_option("--compare", arguments->compare,
                   "Another run of the same sequence, shown on the same clock")
      ->type_name("OTHER.plb");
  verb->add_option("--attach", arguments->attach,
                   "Show what a running graph maps, and how its processes are: the folder that "
                   "'up' told, or a copy of its graph.json on another machine")
      ->type_name("GRAPH");
  verb->add_option("--as", arguments->as, "Whose key to use, where the graph has keys")
      ->capture_default_str();
  verb->add_option(
      "--sequence", arguments->sequence,
      "Where the sequence of a run file is now, or the sequence that belongs to a scan");
  arguments->window.AddTo(*verb);
  // For tests with real input; --help does not list them.
  verb->add_option("--state", arguments->state_file)->group("");
  verb->add_option("--frame-ms", arguments->least_frame_ms)->group("");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Gui(*arguments); }; });
}

}  // namespace plumbline
