// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// One region of the window that answers one question. Owns view state only; asks for everything
/// else by command.
class Panel {
 public:
  virtual ~Panel() = default;
  /// Short name for settings and scripts.
  virtual const char* Id() const = 0;
  virtual const char* Title() const = 0;
  /// What the title's tooltip explains.
  virtual const char* Help() const = 0;
  /// Controls to the right of the title, laid out from the right edge.
  virtual void DrawHeader(const FrameContext&, CommandSink&) {}
  virtual void Draw(const FrameContext& context, CommandSink& sink) = 0;
  virtual nlohmann::json SaveState() const { return nlohmann::json::object(); }
  /// Ignores what it does not know.
  virtual void LoadState(const nlohmann::json&) {}
};

}  // namespace plumbline
