// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/annotation_snapshot.h"
#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// The list of what is probably wrong, to walk through: a click selects and shows the object.
void DrawFindings(const FrameContext& context, CommandSink& sink);
/// Goes to the next finding, or with -1 to the one before.
void WalkFindings(const FrameContext& context, int step, CommandSink& sink);

/// The one that was gone to last, if it can be accepted and the list is shown; else null.
const FindingView* ShownFinding(const FrameContext& context);
/// Asks why it is all right, or opens it again.
void AcceptShownFinding(const FrameContext& context, CommandSink& sink);

}  // namespace plumbline
