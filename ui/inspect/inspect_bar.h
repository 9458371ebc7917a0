// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/common/frame_bars.h"

namespace plumbline {

/// What is open, right of the tabs of the workspaces.
void DrawSequenceName(const FrameContext& context);
/// What plays or is mapped, how fast, and what went wrong.
StatusLine InspectStatus(const FrameContext& context);

}  // namespace plumbline
