// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/layout.h"

namespace plumbline {

/// The strip along the top: program, workspace, what is open.
void DrawTopBar(const FrameContext& context, const LayoutRect& rect, CommandSink& sink);
/// The line along the bottom: what runs, how fast, and what went wrong. `note` is shown for a while
/// after an action.
void DrawStatusBar(const FrameContext& context, const LayoutRect& rect, const std::string& note);
/// All keys and mouse actions, over everything else.
void DrawHelpSheet(const FrameContext& context, CommandSink& sink);

}  // namespace plumbline
