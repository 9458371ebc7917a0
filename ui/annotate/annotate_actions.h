// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/snapshot/commands.h"
#include "ui/framework/actions.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// The Annotate workspace's part of keyboard, palette and help sheet.
std::vector<ActionGroup> AnnotateActions();
/// What the keys ask for that are held, or walk through candidates. Nudges are shown at once and
/// become one edit when the keys are let go.
void PostAnnotateShortcuts(const FrameContext& context, CommandSink& sink);

}  // namespace plumbline
