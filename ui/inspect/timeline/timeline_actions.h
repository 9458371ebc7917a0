// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "ui/framework/actions.h"

namespace plumbline {

/// Playing, stepping, sub-ranges, bookmarks.
ActionGroup PlaybackActions();
/// Playback speeds that [ and ] walk through; 0 is as fast as it goes.
std::span<const double> PlaybackSpeeds();

}  // namespace plumbline
