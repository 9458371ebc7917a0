// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/framework/widgets.h"

namespace plumbline {

/// What panels show before there is a frame. True if they need not go on.
inline bool DrawWaiting(const FrameContext& context) {
  if (context.snapshot != nullptr && context.sequence != nullptr) return false;
  if (context.playback->state == PlaybackState::kFailed) {
    EmptyState(context, "Nothing to show", "The status line at the bottom says what went wrong.");
  } else {
    EmptyState(context, "Opening", "The first frame is being read.");
  }
  return true;
}

}  // namespace plumbline
