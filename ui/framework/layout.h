// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>

#include <imgui.h>

#include "ui/files/layout_ratios.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/panel.h"

namespace plumbline {

struct LayoutRect {
  ImVec2 low, high;
  float width() const { return high.x - low.x; }
  float height() const { return high.y - low.y; }
};

/// What a workspace has to itself: all between the bars.
struct WindowLayout {
  LayoutRect top_bar, room, status_bar;
};
WindowLayout ComputeWindowLayout(ImVec2 size, double ui_scale);

/// Which regions of the Inspect workspace there are; the others take the room of those that are
/// not.
struct InspectRegions {
  bool images = true, map = true, about_map = true, about_object = true, timings = true,
       timeline = true;
};

/// The regions of the Inspect workspace for a window of `size`; one that is not there is empty.
struct InspectLayout {
  LayoutRect top_bar, main, timeline, status_bar;  ///< `main`: all above the timeline.
  LayoutRect left, right, below, row;              ///< Columns; below the map; the row at its end.
  LayoutRect image, edges, depth, masks, particles;
  LayoutRect scene, objects, details, timings;
};
InspectLayout ComputeInspectLayout(ImVec2 size, double ui_scale, const LayoutRatios& ratios,
                                   const InspectRegions& regions = {});
/// Narrower windows have no room for all regions.
bool IsCompact(ImVec2 size, double ui_scale);

/// Draws the invisible handles between the regions and moves `ratios` while one is dragged.
void DragSplitters(const FrameContext& context, const InspectLayout& layout, int image_views,
                   LayoutRatios& ratios);

/// Several panels in one place; the titles of the others are tabs. `active` changes by a click.
void DrawTabbedPanels(const FrameContext& context, const LayoutRect& rect,
                      std::span<Panel* const> panels, std::size_t& active, CommandSink& sink);

/// A panel in its rounded frame with its title row, where it has one. A right click
/// on the title saves the panel as a picture.
/// @param menu  Draws what a click on the title opens; empty: nothing.
void DrawPanel(const FrameContext& context, const LayoutRect& rect, Panel& panel, CommandSink& sink,
               const std::function<void()>& menu = {});

}  // namespace plumbline
