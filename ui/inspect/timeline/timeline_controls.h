// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"
#include "ui/inspect/timeline/timeline_plot.h"

namespace plumbline {

/// The row above the track: playing, the frame's number, sub-range, bookmarks, what is plotted, and
/// the speed.
class TimelineControls {
 public:
  /// @param last  The last frame of the sequence.
  void Draw(const FrameContext& context, int last, CommandSink& sink);
  const PlottedQuantity& plotted() const { return PlottedQuantities()[plot_]; }
  /// An id that is not known changes nothing.
  void Plot(std::string_view id);
  /// Whether true objects that were found have lanes, too.
  bool all_truths() const { return all_truths_; }
  void ShowAllTruths(bool all) { all_truths_ = all; }

 private:
  static void DrawButtons(const FrameContext& context, CommandSink& sink);
  static void DrawNumbers(const FrameContext& context, int last, CommandSink& sink);
  static void DrawRange(const FrameContext& context, CommandSink& sink);
  void DrawBookmarks(const FrameContext& context, CommandSink& sink);
  void DrawChoices(const FrameContext& context, CommandSink& sink);
  void DrawPlotChoice(const FrameContext& context, float width);

  std::size_t plot_ = 0;
  bool all_truths_ = false;
  char note_[200] = "";
};

}  // namespace plumbline
