// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <string>

#include "ui/framework/actions.h"
#include "ui/framework/layout.h"

namespace plumbline {

/// How a workspace stands in the top bar.
struct WorkspaceTab {
  WorkspaceId id = WorkspaceId::kInspect;
  const char* widget = "";  ///< For scripts.
  const char* title = "";
  const char* help = "";
};

struct StatusLine {
  std::string text;
  bool failed = false;  ///< It is bad news.
};

/// The strip along the top: program, workspaces, and what `middle` draws between them and the
/// buttons on the right.
void DrawTopBar(const FrameContext& context, const LayoutRect& rect,
                std::span<const WorkspaceTab> tabs,
                const std::function<void(const LayoutRect&)>& middle, CommandSink& sink);
/// The line along the bottom. `note` is shown for a while after an action.
void DrawStatusBar(const FrameContext& context, const LayoutRect& rect, const StatusLine& status,
                   const std::string& note);
/// The keys of all actions, and the mouse, over everything else.
void DrawHelpSheet(const FrameContext& context, std::span<const ActionGroup> groups,
                   CommandSink& sink);

}  // namespace plumbline
