// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/snapshot/commands.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

// What buttons and keys of the Annotate workspace both do.

/// A pose on its way waits for the command that was posted to make it an edit. `number`: as of
/// AnnotationProcess::Post; nothing: the command was dropped, and so is the pose.
void NotePosted(const AnnotationCommand& command, std::optional<std::uint64_t> number,
                AnnotateView& view);
/// An instance on its way to a pose; the others that are selected and not locked move along with it
/// as one rigid body, unless it is tilted: then they stay.
PendingPose OnItsWay(const FrameContext& context, const AnnotatedInstance& instance,
                     const Eigen::Isometry3d& scan_from_object);
/// What makes it an edit.
SetInstancePoseCommand EditOf(const PendingPose& pending);
/// All that are selected and not locked, each down or up onto the floor.
void PutOntoFloor(const FrameContext& context, CommandSink& sink);
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
/// Where a model would stand, in the level frame: on the scan or, where it has a hole, on the floor
/// if that is known. Pixels of the view.
std::optional<Eigen::Vector3d> PlaceAt(const FrameContext& context, double x_px, double y_px);
void PlaceChosenModel(const FrameContext& context, double x_px, double y_px, CommandSink& sink);
/// The next click, or Enter, places it.
void ChooseModel(const FrameContext& context, const std::string& model, CommandSink& sink);
/// Copies of the selected objects, each beside its own.
void Duplicate(const FrameContext& context, CommandSink& sink);
/// Remembers an object and its pose, to be pasted.
void CopyInstance(const FrameContext& context, const AnnotatedInstance& instance);

/// These objects, the first of them as the one whose numbers are shown; none: nothing.
void SelectInstances(const FrameContext& context, std::vector<std::string> ids, CommandSink& sink);
/// One more, or one less.
void ToggleSelected(const FrameContext& context, const std::string& id, CommandSink& sink);
/// All that are selected, that whose numbers are shown first.
std::vector<std::string> SelectedInstances(const FrameContext& context);

}  // namespace plumbline
