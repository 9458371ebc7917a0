// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "ui/framework/actions.h"
#include "ui/framework/panel.h"

namespace plumbline {

/// Where a panel of the Inspect workspace stands; those of one place come in the table's order.
enum class PanelPlace {
  kImageView,    ///< The left column; the user chooses which view shows which.
  kMap,          ///< Above the right column.
  kAboutMap,     ///< A tab below the map.
  kAboutObject,  ///< A tab below those.
  kTimings,
  kTimeline,
  kOtherRun,  ///< In place of an image view, while two runs show side by side.
  kFigure     ///< Only in figures and films (app/film/render_layout.cc).
};

/// All that there is to say of a panel. Layout, tabs, menus, palette, keys, help sheet and settings
/// follow the table.
struct PanelEntry {
  PanelInfo info;
  PanelPlace place = PanelPlace::kFigure;
  std::unique_ptr<Panel> (*make)() = nullptr;
  ActionGroup (*actions)() = nullptr;  ///< Keys and commands that belong to it; null: none.
  /// Whether there is something that it could show at all; null: always.
  bool (*is_there)(const FrameContext&) = nullptr;
};
std::span<const PanelEntry> InspectPanels();

std::unique_ptr<Panel> MakePanel(const PanelEntry& entry);
/// By its id; null if there is none.
std::unique_ptr<Panel> MakeInspectPanel(std::string_view id);

/// Whether the user may take a panel from the workspace.
bool CanHide(const PanelEntry& entry);

/// What all panels of the table can do, under their headings.
std::vector<ActionGroup> InspectActions();

}  // namespace plumbline
