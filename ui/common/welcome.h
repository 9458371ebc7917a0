// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/layout.h"

namespace plumbline {

/// What stands in place of the panels while nothing is open: how to open something, how far the
/// opening is, or why it failed.
void DrawWelcome(const FrameContext& context, const LayoutRect& rect, CommandSink& sink);

}  // namespace plumbline
