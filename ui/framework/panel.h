// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// What a panel is called, as the table of its workspace says it.
struct PanelInfo {
  const char* id = "";     ///< For settings, layouts and scripts.
  const char* title = "";  ///< On the screen.
  const char* help = "";   ///< What the title's tooltip explains.
  bool has_title_row = true;
};

/// One region of the window that answers one question. Owns view state only; asks for everything
/// else by command.
class Panel {
 public:
  virtual ~Panel() = default;
  const PanelInfo& info() const { return info_; }
  const char* id() const { return info_.id; }
  /// By the table that makes it, once.
  void set_info(const PanelInfo& info) { info_ = info; }
  /// Controls to the right of the title, laid out from the right edge.
  virtual void DrawHeader(const FrameContext&, CommandSink&) {}
  virtual void Draw(const FrameContext& context, CommandSink& sink) = 0;
  virtual nlohmann::json SaveState() const { return nlohmann::json::object(); }
  /// Ignores what it does not know.
  virtual void LoadState(const nlohmann::json&) {}

 private:
  PanelInfo info_;
};

}  // namespace plumbline
