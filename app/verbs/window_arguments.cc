// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/window_arguments.h"

#include <cstdio>

namespace plumbline {

void WindowArguments::AddTo(CLI::App& verb) {
  verb.add_option("--size", size, "Size of the window, for instance 1600x1000");
  verb.add_option("--ui-scale", ui_scale, "Size of text and controls, 1 = normal")
      ->check(CLI::Range(0.6, 4.0));
  verb.add_option("--settings", settings,
                  "File for layout and switches (default: in the user's configuration)");
  verb.add_option("--script", script, "Drive the window from this file and end (docs/panels.md)");
}

Status WindowArguments::Apply(ApplicationOptions& options) const {
  if (!size.empty()) {
    int width = 0, height = 0;
    char rest = 0;
    const int read = std::sscanf(size.c_str(), "%dx%d%c", &width, &height, &rest);
    if (read != 2 || width < 640 || height < 480) {
      return Error{ErrorCode::kInvalidInput,
                   "'" + size + "' is not a size; write --size 1600x1000 (at least 640x480)"};
    }
    options.width = width;
    options.height = height;
  }
  options.ui_scale = ui_scale;
  options.script = script;
  // A script finds the window as it is without settings, so that it does the same everywhere.
  options.settings = !settings.empty() ? std::filesystem::path(settings)
                     : script.empty()  ? DefaultSettingsFile()
                                       : std::filesystem::path();
  return {};
}

}  // namespace plumbline
