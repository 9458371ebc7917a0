// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/framework/frame_context.h"

namespace plumbline {

/// The stages of all frames so far, one upon the other, in the room that is left; point at a frame
/// for its numbers, click to go there.
void DrawTimingsPlot(const FrameContext& context, CommandSink& sink);

/// Colour of the stage at `index` in the order of a frame.
ImU32 StageColor(std::size_t index);

}  // namespace plumbline
