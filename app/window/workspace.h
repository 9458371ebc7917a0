// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/snapshot/commands.h"
#include "ui/common/frame_bars.h"
#include "ui/common/palette.h"
#include "ui/framework/actions.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/layout.h"

namespace plumbline {

/// How long the window may rest before it has to be asked again [s].
struct Pace {
  double shortest_s = 0, longest_s = 1;
};

/// A part of the window with a purpose of its own: its panels and the processes that feed them. The
/// application drives all of them through this; what only one understands, its own group of
/// commands, goes to it directly. Main thread only.
class Workspace {
 public:
  virtual ~Workspace() = default;
  virtual WorkspaceTab tab() const = 0;
  /// What was opened last, as it was named; "": nothing.
  virtual const std::string& source() const = 0;
  /// Whether a path that the user named is for it.
  virtual bool Takes(const std::string& path) const = 0;
  /// For what is opened from now on.
  virtual void UseModels(const std::string& folder) = 0;
  /// Opens it instead of what is open.
  /// @param frame  To show first; nothing: as the workspace sees fit.
  virtual void Open(const std::string& path, std::optional<int> frame, FrameContext& context) = 0;
  /// At the beginning of every frame of the window: takes what its processes have published since.
  virtual void ReadSlots(FrameContext& context) = 0;

  /// It has something to draw; else the application tells how to open something.
  virtual bool IsOpen(const FrameContext& context) const = 0;
  /// It takes the whole window now, bars included.
  virtual bool FillsWindow() const { return false; }
  /// `rect`: all between the bars, or the whole window.
  virtual void Draw(FrameContext& context, const LayoutRect& rect, CommandSink& sink) = 0;
  /// Right of the tabs in the top bar.
  virtual void DrawBar(const FrameContext& context, const LayoutRect& rect, CommandSink& sink) = 0;
  /// Over everything else; true while it has the keyboard to itself.
  virtual bool DrawSheets(const FrameContext&, CommandSink&) { return false; }
  virtual StatusLine status_line(const FrameContext& context) const = 0;

  /// Its part of keyboard, palette and help sheet.
  virtual const std::vector<ActionGroup>& actions() const = 0;
  /// What the palette can find besides: objects, places, files.
  virtual void AddPaletteEntries(const FrameContext&, std::vector<PaletteEntry>&) const {}
  /// What a query stands for by itself.
  virtual std::vector<PaletteEntry> AnswerPalette(const FrameContext&, const std::string&) const {
    return {};
  }
  /// Keys that its actions do not tell of by themselves, such as those that are held.
  virtual void WatchKeys(const FrameContext&, CommandSink&) {}
  /// What would be lost if the window were closed now, and what to do about it; "": nothing.
  virtual std::string WouldBeLost(const FrameContext&) const { return {}; }
  /// While it shows: what becomes of its 3-D view.
  virtual void Handle(const ViewCommand& command, FrameContext& context) = 0;

  /// While it shows, and nothing has happened: whether it must be drawn nevertheless, since
  /// something moves by itself.
  virtual bool Moves(const FrameContext&) { return false; }
  virtual Pace pace(const FrameContext&) const { return {}; }

  /// For scripts and tests.
  virtual void AddState(const FrameContext& context, nlohmann::json& state) const = 0;
  /// Under keys of its own.
  virtual void SaveSettings(const FrameContext& context, nlohmann::json& settings) const = 0;
  /// Ignores what it does not know.
  virtual void LoadSettings(const nlohmann::json& settings, FrameContext& context) = 0;
};

}  // namespace plumbline
