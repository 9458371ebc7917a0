// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/snapshot/object_look.h"
#include "engine/snapshot/playback_view.h"

namespace plumbline {

struct RunReview;

/// Looks of the objects that are confirmed somewhere in these events: of any that live at the same
/// time, no two look alike, up to twice kLookColors.size() of them. A look is chosen when the
/// object is confirmed, from what happened until then, and holds for its whole life: it is the same
/// while a run is mapped, in its file, and wherever one seeks.
/// @param events  By frame, from the first frame of the run on.
ObjectLooks LooksOf(const std::vector<FrameEvent>& events);
ObjectLooks LooksOf(const RunReview& review);

}  // namespace plumbline
