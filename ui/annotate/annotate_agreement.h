// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// What another annotator placed in this scan, object by object: how far it is from here. A click
/// selects the object and shows where the other one has it, as a white outline.
void DrawAgreement(const FrameContext& context, CommandSink& sink);

}  // namespace plumbline
