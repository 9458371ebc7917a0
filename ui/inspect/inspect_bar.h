// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ui/common/frame_bars.h"

namespace plumbline {

/// Arrangements of the panels, and which panels there are. One field is typed into.
class LayoutMenu {
 public:
  void Draw(const FrameContext& context, const LayoutRect& bar, CommandSink& sink);

 private:
  void DrawPopup(const FrameContext& context, CommandSink& sink);
  char name_[48] = "";
};
/// Whether views leave out what is not confirmed.
void DrawConfirmedOnly(const FrameContext& context, const LayoutRect& bar, CommandSink& sink);

/// What is open, right of the tabs of the workspaces.
void DrawSequenceName(const FrameContext& context, const LayoutRect& bar);
/// Which networks find edges and boxes, in the line of the name; opens their sheet.
void DrawNetworksButton(const FrameContext& context, const LayoutRect& bar, CommandSink& sink);
/// What plays or is mapped, how fast, and what went wrong.
StatusLine InspectStatus(const FrameContext& context);

}  // namespace plumbline
