// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/common/frame_bars.h"

namespace plumbline {

/// What is open, right of the tabs of the workspaces.
void DrawSequenceName(const FrameContext& context);
/// Which networks find edges and boxes, in the line of the name; opens their sheet.
void DrawNetworksButton(const FrameContext& context, const LayoutRect& bar, CommandSink& sink);
/// What plays or is mapped, how fast, and what went wrong.
StatusLine InspectStatus(const FrameContext& context);

}  // namespace plumbline
