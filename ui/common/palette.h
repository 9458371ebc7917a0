// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "ui/framework/actions.h"

namespace plumbline {

/// Something that the palette can do.
struct PaletteEntry {
  std::string text;  ///< What it does.
  std::string keys;  ///< The shortcut that does the same; "" for none.
  std::function<void(CommandSink&)> run;
};

/// An entry that posts one command.
template <typename C>
PaletteEntry EntryFor(std::string text, C command) {
  return {std::move(text), "", [command](CommandSink& sink) { sink.Post(command); }};
}

/// The actions that are offered now. They keep a reference to `context`.
std::vector<PaletteEntry> EntriesOf(std::span<const ActionGroup> groups,
                                    const FrameContext& context);
/// What was opened before.
void AddRecentEntries(const FrameContext& context, std::vector<PaletteEntry>& entries);

/// The palette's own state.
struct PaletteState {
  bool open = false;
  char query[128] = "";
  int chosen = 0;
  std::string within;  ///< Only what has these words is offered.
};

/// Over everything else: a field, and what fits. Words may be given in any order, in part; what is
/// typed in full comes first, then what begins so. Up and down choose, Enter does it, Esc closes.
/// Enter is about what is typed by then, be it drawn or not.
/// @param at_once  What the query stands for by itself, such as a frame's number; comes first.
void DrawPalette(const FrameContext& context, PaletteState& state, std::vector<PaletteEntry> all,
                 const std::function<std::vector<PaletteEntry>(const std::string& query)>& at_once,
                 CommandSink& sink);

}  // namespace plumbline
