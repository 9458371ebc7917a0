// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "ui/common/palette.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// The menu "View": what the scan's colours mean, how large its points are, and views to come back
/// to.
void DrawViewMenu(const FrameContext& context);
/// The same for the palette. They keep a reference to `context`.
void AddViewEntries(const FrameContext& context, std::vector<PaletteEntry>& entries);

}  // namespace plumbline
