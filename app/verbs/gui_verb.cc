// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
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
};

Status Gui(GuiArguments& arguments) {
  if (Status status = arguments.pipeline.Finish(); !status.ok()) return status;
  ApplicationOptions options;
  if (Status status = arguments.window.Apply(options); !status.ok()) return status;
  options.inputs = {{}, arguments.sequence, arguments.pipeline.choice.models};
  options.opener =
      SourceOpener({arguments.pipeline.choice, arguments.out, PLUMBLINE_VERSION}, options.inputs);
  const char* user = std::getenv("USER");
  options.annotation = {"", arguments.pipeline.choice.models, arguments.sequence,
                        user != nullptr ? user : ""};
  options.path = arguments.path;
  options.compare = arguments.compare;
  options.program_version = PLUMBLINE_VERSION;
  options.present = arguments.demo;
  options.start_frame = arguments.frame;
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
      "Folder of a sequence, a run file (.plb), a scan (.ply, .pcd, .obj), or an annotation "
      "project (.json); without one the window asks");
  verb->add_option("--frame", arguments->frame, "Frame to show first; the mapper goes up to it");
  verb->add_flag("--demo", arguments->demo,
                 "Full screen, one view after the other with captions, until any key");
  arguments->pipeline.AddTo(*verb);
  verb->add_option("--out", arguments->out,
                   "Keep the run that the window maps in this file (.plb)");
  verb->add_option("--compare", arguments->compare,
                   "Another run of the same sequence, shown on the same clock")
      ->type_name("OTHER.plb");
  verb->add_option(
      "--sequence", arguments->sequence,
      "Where the sequence of a run file is now, or the sequence that belongs to a scan");
  arguments->window.AddTo(*verb);
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Gui(*arguments); }; });
}

}  // namespace plumbline
