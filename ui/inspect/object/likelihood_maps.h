// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/framework/frame_context.h"

namespace plumbline {

/// The score over two parameters at once, as colours, in the room that is left. `term` (0 the whole
/// score, 1 edges, 2 detector) changes by a click on its name.
void DrawLikelihoodMaps(const FrameContext& context, const ProbeView& probe, int& term);

}  // namespace plumbline
