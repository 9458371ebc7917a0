// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/commands.h"
#include "engine/snapshot/label_history.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// What an object was believed to be over time: the probability of each shape as an area upon those
/// before it, with a legend; the values of a frame under the mouse; a click goes to that frame.
void DrawLabelPlot(const FrameContext& context, const LabelHistory& history, ImVec2 corner,
                   ImVec2 size, CommandSink& sink);

}  // namespace plumbline
