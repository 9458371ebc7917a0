// SPDX-License-Identifier: Apache-2.0
// Stands in for what opens the window where it was left out of the build.

#include "app/verbs/demo_window.h"
#include "app/verbs/verb.h"

namespace plumbline {
namespace {

Status NoWindow() {
  return Error{ErrorCode::kUnsupported,
               "this build has no window; configure it with -DPLUMBLINE_UI=ON"};
}

}  // namespace

void AddGuiVerb(CLI::App& app, VerbFunction& chosen) {
  CLI::App* verb = app.add_subcommand("gui", "Open the window (not in this build)");
  verb->add_option_function<std::string>(
      "path", [](const std::string&) {}, "Sequence or run file");
  verb->callback([&chosen] { chosen = NoWindow; });
}

void AddRenderVerb(CLI::App& app, VerbFunction& chosen) {
  CLI::App* verb = app.add_subcommand("render", "Film a run (not in this build)");
  verb->allow_extras();
  verb->callback([&chosen] { chosen = NoWindow; });
}

Status ShowDemoWindow(const std::filesystem::path&) { return NoWindow(); }

Status FilmDemoWindow(const std::filesystem::path&, const std::filesystem::path&,
                      const WorkContext&) {
  return NoWindow();
}

}  // namespace plumbline
