// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "ui/framework/actions.h"
#include "ui/framework/layout.h"
#include "ui/framework/panel.h"

namespace plumbline {

// Panels of the Annotate workspace, each in a file of its own. docs/annotate_guide.md shows them.

std::unique_ptr<Panel> MakeAnnotateScenePanel();
std::unique_ptr<Panel> MakeAnnotateModelsPanel();
std::unique_ptr<Panel> MakeAnnotateInstancesPanel();
std::unique_ptr<Panel> MakeAnnotateImagesPanel();
// One of these stands on the right: whatever is to be decided now, else the selected object.
std::unique_ptr<Panel> MakeAnnotateFloorPanel();
std::unique_ptr<Panel> MakeAnnotateCandidatesPanel();
std::unique_ptr<Panel> MakeAnnotateRefinementPanel();
std::unique_ptr<Panel> MakeAnnotateInstancePanel();
std::unique_ptr<Panel> MakeAnnotateCropPanel();
std::unique_ptr<Panel> MakeAnnotateSequencePanel();
/// Stands in the place of the images while a sequence is registered.
std::unique_ptr<Panel> MakeAnnotateFramePanel();

/// Stands there while the masks of a frame are looked at.
std::unique_ptr<Panel> MakeAnnotateMasksPanel();

/// All panels of the workspace, as InspectPanels is for the other one.
struct AnnotatePanelEntry {
  PanelInfo info;
  std::unique_ptr<Panel> (*make)() = nullptr;
};
std::span<const AnnotatePanelEntry> AnnotatePanels();
/// By its id, with what the table says of it; null if there is none.
std::unique_ptr<Panel> MakeAnnotatePanel(std::string_view id);

/// What the user must know, over the top of the 3-D view: edits that cannot be written, notices.
void DrawAnnotateBanners(const FrameContext& context, ImVec2 low, ImVec2 high, CommandSink& sink);
/// The sheet of the scans that wait, and of how far the project is.
void DrawQueue(const FrameContext& context, CommandSink& sink);
float QueueWidth(const FrameContext& context);  ///< Of that sheet, with its edges.
/// The sheet that writes other formats.
void DrawExport(const FrameContext& context, CommandSink& sink);

/// What a right click offers: what can be done with the selected object or, without one, in the
/// scan.
void DrawAnnotateMenu(const FrameContext& context, std::span<const ActionGroup> groups,
                      CommandSink& sink);

/// What is open, and what can be done with it as a whole: save, undo, redo. Right of the tabs.
void DrawProjectBar(const FrameContext& context, const LayoutRect& rect, CommandSink& sink);
/// What the status bar says; `bad`: it is a failure.
std::string AnnotationStatus(const FrameContext& context, bool& bad);

}  // namespace plumbline
