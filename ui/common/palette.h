// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Something that the palette can do.
struct PaletteEntry {
  std::string text;  ///< What it does.
  std::string keys;  ///< The shortcut that does the same; "" for none.
  std::function<void(CommandSink&)> run;
};

/// All that fits `query`: every shortcut, views, objects, bookmarks, recent files; a number goes to
/// that frame. Words may be given in any order, in part.
std::vector<PaletteEntry> PaletteEntries(const FrameContext& context, const std::string& query);

/// The palette's own state.
struct PaletteState {
  bool open = false;
  char query[128] = "";
  int chosen = 0;
};

/// Over everything else: a field, and what fits. Up and down choose, Enter does it, Esc closes.
void DrawPalette(const FrameContext& context, PaletteState& state, CommandSink& sink);

}  // namespace plumbline
