// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <optional>

#include "app/verbs/open_source.h"
#include "app/verbs/pipeline_arguments.h"
#include "app/verbs/verb.h"
#include "app/verbs/window_arguments.h"
#include "app/window/application.h"

namespace plumbline {
namespace {

struct GuiArguments {
  PipelineArguments pipeline;
  WindowArguments window;
  std::string path, sequence, out, compare;
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
