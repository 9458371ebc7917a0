// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/truths_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Why a true instance is in the map, or not, over the whole run: the verdict, how much of it the
/// run has seen, what became of the boxes over it, and the candidates that came near. A click on a
/// candidate goes to the frame in which it was nearest and selects it.
void DrawMissedView(const FrameContext& context, const TruthView& truth, CommandSink& sink);

}  // namespace plumbline
