// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>

#include "app/application.h"
#include "app/verbs/pipeline_arguments.h"
#include "app/verbs/verb.h"
#include "engine/process/live_source.h"
#include "engine/process/run_source.h"

namespace plumbline {
namespace {

struct GuiArguments {
  PipelineArguments pipeline;
  std::string path, sequence, out, script, settings, size;
  std::optional<int> frame;
  std::optional<double> ui_scale;
};

/// Run files by their ending, everything else is a sequence.
MappingProcess::OpenSource Opener(const std::string& path, const GuiArguments& arguments) {
  return [path, arguments](const WorkContext& work) -> Result<std::unique_ptr<SnapshotSource>> {
    if (std::filesystem::path(path).extension() == ".plb") {
      return OpenRunSource({path, arguments.sequence, arguments.pipeline.choice.models}, work);
    }
    LiveChoice choice;
    choice.pipeline = arguments.pipeline.choice;
    choice.pipeline.sequence = path;
    choice.out = arguments.out;
    choice.program_version = PLUMBLINE_VERSION;
    return OpenLiveSource(choice, work);
  };
}

Status ReadSize(const std::string& text, ApplicationOptions& options) {
  if (text.empty()) return {};
  int width = 0, height = 0;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%dx%d%c", &width, &height, &rest) != 2 || width < 640 ||
      height < 480) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + text + "' is not a size; write --size 1600x1000 (at least 640x480)"};
  }
  options.width = width;
  options.height = height;
  return {};
}

Status Gui(GuiArguments& arguments) {
  if (Status status = arguments.pipeline.Finish(); !status.ok()) return status;
  ApplicationOptions options;
  if (Status status = ReadSize(arguments.size, options); !status.ok()) return status;
  options.opener = [arguments](const std::string& path) { return Opener(path, arguments); };
  options.path = arguments.path;
  options.start_frame = arguments.frame;
  options.ui_scale = arguments.ui_scale;
  options.script = arguments.script;
  // A script finds the window as it is without settings, so that it does the same everywhere.
  options.settings = !arguments.settings.empty() ? std::filesystem::path(arguments.settings)
                     : arguments.script.empty()  ? DefaultSettingsFile()
                                                 : std::filesystem::path();
  auto application = Application::Create(std::move(options));
  if (!application.ok()) return application.error();
  return (*application)->Run();
}

}  // namespace

void AddGuiVerb(CLI::App& app, VerbFunction& chosen) {
  auto arguments = std::make_shared<GuiArguments>();
  CLI::App* verb = app.add_subcommand(
      "gui", "Open the window: play a sequence through the mapper, or a recorded run");
  verb->add_option("path", arguments->path,
                   "Folder of a sequence, or a run file (.plb); without one the window asks");
  verb->add_option("--frame", arguments->frame, "Frame to show first; the mapper goes up to it");
  arguments->pipeline.AddTo(*verb);
  verb->add_option("--out", arguments->out,
                   "Keep the run that the window maps in this file (.plb)");
  verb->add_option("--sequence", arguments->sequence, "Where the sequence of a run file is now");
  verb->add_option("--size", arguments->size, "Size of the window, for instance 1600x1000");
  verb->add_option("--ui-scale", arguments->ui_scale, "Size of text and controls, 1 = normal")
      ->check(CLI::Range(0.6, 4.0));
  verb->add_option("--settings", arguments->settings,
                   "File for layout and switches (default: in the user's configuration)");
  verb->add_option("--script", arguments->script,
                   "Drive the window from this file and end (docs/panels.md)");
  verb->callback([arguments, &chosen] { chosen = [arguments] { return Gui(*arguments); }; });
}

}  // namespace plumbline
