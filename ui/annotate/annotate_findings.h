// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// The list of what is probably wrong, to walk through: a click selects and shows the object.
void DrawFindings(const FrameContext& context, CommandSink& sink);
/// Goes to the next finding, or with -1 to the one before.
void WalkFindings(const FrameContext& context, int step, CommandSink& sink);

}  // namespace plumbline
