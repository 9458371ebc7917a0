// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/snapshot/commands.h"
#include "ui/framework/actions.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

// What buttons and keys of the Annotate workspace both do.

/// A pose on its way waits for the command that was posted to make it an edit. `number`: as of
/// AnnotationProcess::Post; nothing: the command was dropped, and so is the pose.
void NotePosted(const AnnotationCommand& command, std::optional<std::uint64_t> number,
                AnnotateView& view);
/// Brings the view in step with a new snapshot: a pose on its way is shown until its command was
/// carried out or refused; a candidate that was chosen stays chosen where the images change the
/// order, and is forgotten with its placement.
void FollowSnapshot(const AnnotationSnapshot& before, const AnnotationSnapshot& now,
                    AnnotateView& view);

/// Takes what is proposed; of a placement, the candidate at that place in the list.
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
