// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/snapshot/commands.h"
#include "ui/framework/actions.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

// What buttons and keys of the Annotate workspace both do.

/// Takes what is proposed; of a placement, the candidate.
void AcceptProposal(const FrameContext& context, int candidate, CommandSink& sink);
/// All azimuths again for the selected object.
void PlaceAgain(const FrameContext& context, CommandSink& sink);
/// Proposes to cut out what is inside the box, or the line that was drawn in the 3-D view.
void ProposeCrop(const FrameContext& context, CommandSink& sink);
/// Forgets box, line and what would have been cut out by them.
void DropCut(const FrameContext& context, CommandSink& sink);
/// A copy of the selected object beside it.
void Duplicate(const FrameContext& context, CommandSink& sink);

/// Its keys, which PostAnnotateShortcuts watches, with the rows of the help sheet.
std::vector<ActionGroup> AnnotateActions();
/// What the keys that went down in this ImGui frame ask for. Nudges are shown at once and become
/// one edit when the keys are let go.
void PostAnnotateShortcuts(const FrameContext& context, CommandSink& sink);

}  // namespace plumbline
