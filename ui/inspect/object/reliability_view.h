// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <imgui.h>

#include "engine/snapshot/object_history.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// In few words and figures: how often the truth lies where the beliefs say, for the object and
/// all.
void DrawReliabilitySummary(const FrameContext& context, const ObjectHistory& history);

/// Every object's figures, the reliability diagram of shapes, and precision over recall of being
/// there.
void DrawReliability(const FrameContext& context, const ObjectHistory& history, ImVec2 corner,
                     ImVec2 size);

}  // namespace plumbline
