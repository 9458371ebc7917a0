// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/panel_table.h"

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "ui/files/layout_ratios.h"
#include "ui/inspect/compare/what_if_panel.h"
#include "ui/inspect/image/depth_panel.h"
#include "ui/inspect/image/edges_panel.h"
#include "ui/inspect/image/image_panel.h"
#include "ui/inspect/image/masks_panel.h"
#include "ui/inspect/image/other_image_panel.h"
#include "ui/inspect/image/particles_panel.h"
#include "ui/inspect/inertial/inertial_panel.h"
#include "ui/inspect/inspect_bar.h"
#include "ui/inspect/map/scene_panel.h"
#include "ui/inspect/object/details_panel.h"
#include "ui/inspect/object/objects_panel.h"
#include "ui/inspect/object/particle_table_panel.h"
#include "ui/inspect/object/posterior_panel.h"
#include "ui/inspect/object/relations_panel.h"
#include "ui/inspect/object/why_panel.h"
#include "ui/inspect/processes/processes_panel.h"
#include "ui/inspect/timeline/flow_panel.h"
#include "ui/inspect/timeline/timeline_actions.h"
#include "ui/inspect/timeline/timeline_panel.h"
#include "ui/inspect/timeline/timings_panel.h"

namespace plumbline {
namespace {

constexpr PanelEntry kPanels[] = {
    {{"timeline", "Timeline", "Where in the sequence the window is.", false},
     PanelPlace::kTimeline,
     MakeTimelinePanel,
     PlaybackActions},
    {{"image", "Image",
      "The camera's image with the detector's proposals and the outlines of the objects' mean "
      "states.\nWheel zooms, dragging moves, double click shows all; a click selects an object."},
     PanelPlace::kImageView,
     MakeImagePanel,
     ImageViewActions},
    {{"edges", "Edges",
      "What the edge detector sees, thinned to lines: colour is the direction of the edge (the fan "
      "shows which), brightness its probability."},
     PanelPlace::kImageView,
     MakeEdgesPanel},
    {{"depth", "Z-buffer",
      "Depth of the mean states of all objects in this camera. Bright is near; the scale is in "
      "metres. It decides which parts hide which."},
     PanelPlace::kImageView,
     MakeDepthPanel},
    {{"masks", "Masks",
      "Visible part of every object's mean state over the image, in the object's colour, darker "
      "the closer."},
     PanelPlace::kImageView,
     MakeMasksPanel},
    {{"particles", "Particles",
      "The hypotheses of the selected object over the image: a dot where each puts the centre of "
      "the model, a line along the model's front. Brighter means more weight. Point at one for its "
      "numbers and its outline, click to mark it in the images and in 3-D."},
     PanelPlace::kImageView,
     MakeParticlesPanel},
    {{"scene", "Map",
      "The map in 3-D. Left drag turns, right drag (or middle, or Shift and left) moves, the wheel "
      "zooms, double click turns about what is under the mouse, a click selects. F frames the "
      "selected object, R resets."},
     PanelPlace::kMap,
     MakeScenePanel,
     MapActions},
    {{"objects", "Objects",
      "All objects of the map in this frame. Click one to select it, double click to frame it in "
      "3-D."},
     PanelPlace::kAboutMap,
     MakeObjectsPanel,
     SelectionActions},
    {{"relations", "Relations",
      "How the confirmed objects of this frame stand to one another: what stands on what, what "
      "hides what from the camera, and the nearest neighbour of each. Click a row to select its "
      "first object. The switch Links draws them in the map."},
     PanelPlace::kAboutMap,
     MakeRelationsPanel},
    {{"inertial", "Inertial",
      "Of a run that finds its own poses (--poses vio): what the IMU reads, what the filter "
      "believes and how surely, what it waits for, and how far it is from the reference, if there "
      "is one. The switch Tracks of the image shows the points that it follows."},
     PanelPlace::kAboutMap,
     MakeInertialPanel},
    {{"what_if", "What if?",
      "Two runs of one sequence on one clock, and what differs. Fork makes the second run: the "
      "past up to this frame, then other options or another seed."},
     PanelPlace::kAboutMap,
     MakeWhatIfPanel,
     TwoRunActions},
    {{"processes", "Processes",
      "The processes that map what is shown (plumbline up): whether each answers, what it says of "
      "itself, how much flows through it and how long that takes. Point at one for whom it asks."},
     PanelPlace::kAboutMap,
     MakeProcessesPanel,
     nullptr,
     [](const FrameContext& context) { return context.graph != nullptr; }},
    {{"details", "Selected object",
      "What the filter believes about the selected object: which shape it is, where, and how "
      "surely."},
     PanelPlace::kAboutObject,
     MakeDetailsPanel},
    {{"why", "Why here?",
      "Scores the selected object in this frame again by the mapper's own rule, together with "
      "what it did not try: the true place, and places around the mean. It tells whether the "
      "search or the likelihood is to blame. Detector scores come from the frame's proposals: "
      "exact for recorded proposals, close for networks."},
     PanelPlace::kAboutObject,
     MakeWhyPanel},
    {{"posterior", "Belief",
      "How the hypotheses of the selected object spread along each parameter, in the camera of its "
      "reference time; what it was believed to be over time; and, where there is ground truth, "
      "whether the beliefs of this run are reliable: the truth should lie in half of the 50 % "
      "regions and in 95 of 100 of the 95 % regions. Where the poses are the run's own, what the "
      "image of reference may be off by is added before that is counted."},
     PanelPlace::kAboutObject,
     MakePosteriorPanel},
    {{"particle_table", "Particle list",
      "All hypotheses of the selected object in numbers. Click a heading to sort, a row to mark "
      "the hypothesis in the images and in the map."},
     PanelPlace::kAboutObject,
     MakeParticleTablePanel},
    {{"timings", "Timings",
      "Time that each stage took in this frame (bar and number), and its mean over the run. Below: "
      "what "
      "the window itself takes."},
     PanelPlace::kTimings,
     MakeTimingsPanel},
    {{"flow", "Pathways",
      "How a frame becomes map: the edge pathway above, the detector pathway below, the filter "
      "where they meet, with the milliseconds of this frame."},
     PanelPlace::kFigure,
     MakeFlowPanel},
    {{"other_image", "Other run",
      "The same frame as the other run left it, with the switches, the zoom and the selection of "
      "the first."},
     PanelPlace::kOtherRun,
     MakeOtherImagePanel},
};

}  // namespace

std::span<const PanelEntry> InspectPanels() { return kPanels; }

std::unique_ptr<Panel> MakePanel(const PanelEntry& entry) {
  std::unique_ptr<Panel> panel = entry.make();
  panel->set_info(entry.info);
  return panel;
}

std::unique_ptr<Panel> MakeInspectPanel(std::string_view id) {
  for (const PanelEntry& entry : kPanels) {
    if (id == entry.info.id) return MakePanel(entry);
  }
  return nullptr;
}

bool CanHide(const PanelEntry& entry) {
  return entry.place != PanelPlace::kFigure && entry.place != PanelPlace::kOtherRun;
}

namespace {

/// Of the panel under the mouse; "" if there is none.
std::string PanelUnderMouse(const FrameContext& context) {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  for (const PanelEntry& entry : kPanels) {
    const auto* rect = context.widgets->Find(std::string("panel.") + entry.info.id);
    if (rect != nullptr && mouse.x >= rect->low.x && mouse.x < rect->high.x &&
        mouse.y >= rect->low.y && mouse.y < rect->high.y)
      return entry.info.id;
  }
  return "";
}

ActionGroup PanelActions() {
  ActionGroup group{"Panels", {}};
  group.actions.push_back(
      {.text = "Panels: the one under the mouse fills the window",
       .keys = {{keys::kM}},
       .run =
           [](const FrameContext& context, CommandSink& sink) {
             sink.Post(MaximizePanelCommand{context.maximized.empty() ? PanelUnderMouse(context)
                                                                      : std::string()});
           },
       .help_keys = "M",
       .help = "The panel under the mouse fills the window, and back",
       .text_when_on = "Panels: bring all back",
       .is_on = [](const FrameContext& context) { return !context.maximized.empty(); }});
  group.actions.push_back(
      {.text = "Show confirmed objects only",
       .keys = {{keys::kC}},
       .run = [](const FrameContext& context,
                 CommandSink& sink) { sink.Post(ConfirmedOnlyCommand{!context.confirmed_only}); },
       .help_keys = "C",
       .help = "Confirmed objects only, in all views",
       .text_when_on = "Show unconfirmed objects, too",
       .is_on = [](const FrameContext& context) { return context.confirmed_only; }});
  for (const std::string_view name : kBuiltInLayouts)
    group.actions.push_back({.text = fmt::format("Layout: {}", name),
                             .run = Posts(ChooseLayoutCommand{std::string(name)})});
  return group;
}

}  // namespace

std::vector<ActionGroup> InspectActions() {
  std::vector<ActionGroup> groups;
  for (const PanelEntry& entry : kPanels) {
    if (entry.actions != nullptr) groups.push_back(entry.actions());
  }
  ActionGroup shown = PanelActions();
  for (const PanelEntry& entry : kPanels) {
    const bool tab =
        entry.place == PanelPlace::kAboutMap || entry.place == PanelPlace::kAboutObject;
    if (CanHide(entry))
      shown.actions.push_back({.text = std::string("Maximize panel: ") + entry.info.title,
                               .run = Posts(MaximizePanelCommand{entry.info.id})});
    if (tab)
      shown.actions.push_back({.text = std::string("Show panel: ") + entry.info.title,
                               .run = Posts(ShowPanelCommand{entry.info.id}),
                               .is_offered = entry.is_there});
    if (entry.place == PanelPlace::kFigure || entry.place == PanelPlace::kOtherRun) continue;
    shown.actions.push_back(
        {.text = std::string("Save a picture of the panel: ") + entry.info.title,
         .run = Posts(ScreenshotCommand{"", std::string("panel.") + entry.info.id}),
         .is_offered = [name = std::string("panel.") + entry.info.id](const FrameContext& context) {
           return context.widgets->Find(name) != nullptr;
         }});
  }
  groups.push_back(std::move(shown));
  return groups;
}

}  // namespace plumbline
