// SPDX-License-Identifier: Apache-2.0
// Stands in for the commands that open the window where it was left out of the build.

#include "app/verbs/verb.h"

namespace plumbline {

void AddGuiVerb(CLI::App& app, VerbFunction& chosen) {
  CLI::App* verb = app.add_subcommand("gui", "Open the window (left out of this build)");
  verb->allow_extras();
  verb->callback([&chosen] {
    chosen = [] {
      return Status(Error{ErrorCode::kUnsupported,
                          "this build has no window; configure it with -DPLUMBLINE_UI=ON"});
    };
  });
}

}  // namespace plumbline
