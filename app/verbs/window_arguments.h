// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <CLI/CLI.hpp>

#include "app/window/application.h"

namespace plumbline {

/// What the commands that open the window share.
struct WindowArguments {
  std::string script, settings, size;
  std::optional<double> ui_scale;

  /// Declares --size, --ui-scale, --settings and --script.
  void AddTo(CLI::App& verb);
  /// Errors: kInvalidInput (a size that is none).
  Status Apply(ApplicationOptions& options) const;
};

}  // namespace plumbline
