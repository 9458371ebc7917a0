// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "engine/snapshot/commands.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/path_dialog.h"

namespace plumbline {

/// What another annotator placed in this scan, object by object: how far it is from here. A click
/// selects the object and shows where the other one has it, as a white outline.
void DrawAgreement(const FrameContext& context, CommandSink& sink);

/// Which project or ground truth to compare with. `view` outlives the answer.
PathQuestion AgreementQuestion(AnnotateView& view);

/// Compares, and lists the outcome in place of the checks.
void CompareWith(const std::string& path, AnnotateView& view, CommandSink& sink);

}  // namespace plumbline
