// SPDX-License-Identifier: Apache-2.0
// What the workspace draws, and what it keeps from one day to the next.

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "app/window/inspect/inspect_workspace.h"
#include "engine/geometry/angles.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/snapshot/truths_view.h"
#include "ui/files/kept_value.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/inspect_bar.h"

namespace plumbline {
namespace {

const char* StateName(PlaybackState state) {
  switch (state) {
    case PlaybackState::kPaused:
      return "paused";
    case PlaybackState::kPlaying:
      return "playing";
    case PlaybackState::kFinished:
      return "finished";
    case PlaybackState::kFailed:
      return "failed";
  }
  return "";
}

}  // namespace

void InspectWorkspace::Draw(FrameContext& context, const LayoutRect& rect, CommandSink& sink) {
  if (is_figure()) return DrawFigure(context, rect.high, sink);
  if (!presenter_.active()) return DrawPanels(context, sink);
  if (!presenter_.Draw(context, rect.high, panels_, sink)) return;
  Present(false, context);
  if (quit_after_presenting_) window_.Post(QuitCommand{});
}

void InspectWorkspace::DrawFigure(const FrameContext& context, ImVec2 size, CommandSink& sink) {
  const float gap = context.Scaled(4);
  for (const PlacedPanel& placed : options_.layout->panels) {
    const LayoutRect rect{{placed.x0 * size.x + 0.5f * gap, placed.y0 * size.y + 0.5f * gap},
                          {placed.x1 * size.x - 0.5f * gap, placed.y1 * size.y - 0.5f * gap}};
    for (Panel* panel : panels_) {
      if (std::string_view(panel->id()) == placed.panel) DrawPanel(context, rect, *panel, sink);
    }
  }
}

std::vector<Panel*> InspectWorkspace::ShownAt(const FrameContext& context, PanelPlace place) const {
  std::vector<Panel*> shown;
  for (std::size_t i = 0; i < panels_.size(); ++i) {
    const PanelEntry& entry = InspectPanels()[i];
    const bool there = entry.is_there == nullptr || entry.is_there(context);
    if (entry.place == place && there && !context.hidden_panels.contains(entry.info.id))
      shown.push_back(panels_[i]);
  }
  return shown;
}

void InspectWorkspace::DrawTabs(const FrameContext& context, const LayoutRect& rect,
                                std::span<Panel* const> shown, std::span<Panel* const> all,
                                std::size_t& front, CommandSink& sink) const {
  if (shown.empty()) return;
  const auto place = [](std::span<Panel* const> in, Panel* panel) {
    return static_cast<std::size_t>(std::find(in.begin(), in.end(), panel) - in.begin());
  };
  std::size_t active = front < all.size() ? place(shown, all[front]) : 0;
  if (active == shown.size()) active = 0;
  DrawTabbedPanels(context, rect, shown, active, sink);
  front = place(all, shown[active]);
}

void InspectWorkspace::DrawAllTabs(const FrameContext& context, const LayoutRect& rect,
                                   CommandSink& sink) {
  std::vector<Panel*> tabs;
  for (const PanelPlace place :
       {PanelPlace::kAboutMap, PanelPlace::kAboutObject, PanelPlace::kTimings}) {
    const std::vector<Panel*> there = ShownAt(context, place);
    tabs.insert(tabs.end(), there.begin(), there.end());
  }
  if (tabs.empty()) return;
  std::size_t active = 0;
  for (std::size_t i = 0; i < tabs.size(); ++i) {
    if (compact_tab_ == tabs[i]->id()) active = i;
  }
  const std::size_t before = active;
  DrawTabbedPanels(context, rect, tabs, active, sink);
  if (active != before) ShowPanel(tabs[active]->id());
}

void InspectWorkspace::DrawPanels(FrameContext& context, CommandSink& sink) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const bool compact = IsCompact(size, context.ui_scale);
  const auto any = [&](PanelPlace place) { return !ShownAt(context, place).empty(); };
  InspectRegions regions{any(PanelPlace::kImageView), any(PanelPlace::kMap),
                         any(PanelPlace::kAboutMap),  any(PanelPlace::kAboutObject),
                         any(PanelPlace::kTimings),   any(PanelPlace::kTimeline)};
  if (compact) {
    regions.about_map = regions.about_map || regions.about_object || regions.timings;
    regions.about_object = regions.timings = false;
  }
  const InspectLayout layout = ComputeInspectLayout(size, context.ui_scale, ratios_, regions);
  Panel& timeline = PanelAt(PanelPlace::kTimeline);
  if (context.maximized == timeline.id())
    return DrawPanel(context, {layout.main.low, layout.timeline.high}, timeline, sink);
  if (regions.timeline) DrawPanel(context, layout.timeline, timeline, sink);
  if (!context.maximized.empty()) return DrawMaximized(context, layout, sink);
  const bool beside = context.run_shown == RunShown::kBeside && context.other != nullptr;
  Panel& other_image = PanelAt(PanelPlace::kOtherRun);
  if (beside) other_image.LoadState(PanelAt(PanelPlace::kImageView).SaveState());
  const int views = compact ? 1 : ImageViews::kMost;
  if (regions.images) views_->Draw(context, layout, views, beside ? &other_image : nullptr, sink);
  if (regions.map) DrawPanel(context, layout.scene, PanelAt(PanelPlace::kMap), sink);
  if (compact) {
    DrawAllTabs(context, layout.objects, sink);
  } else {
    DrawTabs(context, layout.objects, ShownAt(context, PanelPlace::kAboutMap),
             PanelsAt(PanelPlace::kAboutMap), map_tab_, sink);
    const bool wide = object_tab_ > 0 && regions.about_object;  // it needs the room
    DrawTabs(context, wide ? layout.row : layout.details,
             ShownAt(context, PanelPlace::kAboutObject), PanelsAt(PanelPlace::kAboutObject),
             object_tab_, sink);
    if (!wide && regions.timings)
      DrawPanel(context, layout.timings, PanelAt(PanelPlace::kTimings), sink);
  }
  const int shown = beside ? 2 : std::min(views, views_->Shown(context));
  DragSplitters(context, layout, shown, ratios_);
}

/// In the room of all but the timeline.
void InspectWorkspace::DrawMaximized(FrameContext& context, const InspectLayout& layout,
                                     CommandSink& sink) {
  const std::string id = context.maximized;
  for (std::size_t i = 0; i < panels_.size(); ++i) {
    if (id != panels_[i]->id()) continue;
    const PanelPlace place = InspectPanels()[i].place;
    const bool tabs = place == PanelPlace::kAboutMap || place == PanelPlace::kAboutObject;
    if (!tabs) return DrawPanel(context, layout.main, *panels_[i], sink);
    std::size_t& front = place == PanelPlace::kAboutMap ? map_tab_ : object_tab_;
    const std::vector<Panel*> all = PanelsAt(place);
    DrawTabs(context, layout.main, ShownAt(context, place), all, front, sink);
    context.maximized = all[front]->id();
    return;
  }
  context.maximized.clear();
}

void InspectWorkspace::DrawBar(const FrameContext& context, const LayoutRect& rect,
                               CommandSink& sink) {
  DrawSequenceName(context, rect);
  layout_menu_.Draw(context, rect, sink);
  DrawConfirmedOnly(context, rect, sink);
  DrawNetworksButton(context, rect, sink);
}

bool InspectWorkspace::DrawSheets(const FrameContext& context, CommandSink& sink) {
  // The key that closes one does nothing else.
  const auto any_open = [&] {
    return fork_sheet_.is_open() || networks_sheet_.is_open() || batch_sheet_.is_open();
  };
  const bool was_open = any_open();
  fork_sheet_.Draw(context, sink);
  networks_sheet_.Draw(context, sink);
  batch_sheet_.Draw(context, batches_.View().get(), sink);
  return was_open || any_open();
}

StatusLine InspectWorkspace::status_line(const FrameContext& context) const {
  return InspectStatus(context);
}

void InspectWorkspace::AddPaletteEntries(const FrameContext& context,
                                         std::vector<PaletteEntry>& entries) const {
  if (context.snapshot != nullptr) {
    for (const ObjectReport& object : context.snapshot->report.objects) {
      const ModelView* model = context.Model(object.label);
      entries.push_back(EntryFor(
          fmt::format("Select object #{} {} ({})", object.id.value,
                      model != nullptr ? model->name : object.category, NameOf(object.state)),
          SelectObjectCommand{object.id}));
    }
  }
  for (const Bookmark& bookmark : context.bookmarks)
    entries.push_back(EntryFor(fmt::format("Bookmark {} {}", bookmark.frame, bookmark.note),
                               SeekCommand{bookmark.frame}));
  for (const std::string& path : context.recent) {
    if (path.ends_with(".plb") && !context.playback->recording.empty())
      entries.push_back(EntryFor("Compare with " + path, CompareRunCommand{path}));
  }
}

/// A number goes to that frame.
std::vector<PaletteEntry> InspectWorkspace::AnswerPalette(const FrameContext& context,
                                                          const std::string& query) const {
  const bool number =
      !query.empty() && query.size() < 8 &&
      std::all_of(query.begin(), query.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!number || context.sequence == nullptr) return {};
  const int frame = std::min(std::stoi(query), context.sequence->num_frames - 1);
  return {EntryFor(fmt::format("Go to frame {}", frame), SeekCommand{frame})};
}

void InspectWorkspace::AddState(const FrameContext& context, nlohmann::json& state) const {
  const PlaybackView& playback = *context.playback;
  const SceneCamera camera = scene_->camera();
  const auto& samples = playback.history->frames;
  state.update(
      {{"frame", context.snapshot != nullptr ? context.snapshot->report.frame : -1},
       {"playback_frame", playback.frame},
       {"newest_frame", playback.newest_mapped_frame},
       {"open", context.sequence != nullptr},
       {"num_frames", context.sequence != nullptr ? context.sequence->num_frames : 0},
       {"state", StateName(playback.state)},
       {"seeking", playback.seek_target.has_value()},
       {"recorded", playback.recorded},
       {"growing", playback.growing},
       {"nodes_answer",
        context.graph == nullptr
            ? -1
            : std::count_if(context.graph->nodes.begin(), context.graph->nodes.end(),
                            [](const NodeView& node) { return node.answers; })},
       {"speed", playback.speed},
       {"mapping", playback.mapping},
       {"follow_newest", playback.follow},
       {"live", playback.live.has_value()},
       {"passed_over", playback.live ? playback.live->passed_over : 0},
       {"loop", playback.loop},
       {"range", {playback.range_begin.value_or(-1), playback.range_end.value_or(-1)}},
       {"history", std::count_if(samples.begin(), samples.end(),
                                 [](const auto& sample) { return sample != nullptr; })},
       {"message", playback.message},
       {"objects", context.snapshot != nullptr ? context.snapshot->report.objects.size() : 0},
       {"selected_object", context.selection.object.value},
       {"selected_truth", context.selection.truth},
       {"missed", context.truths != nullptr ? context.truths->missed : -1},
       {"selected_particle", context.selection.particle},
       {"hovered_particle", context.selection.hovered},
       {"outlined_particle", context.probe != nullptr ? context.probe->hovered : -1},
       {"selected_hypothesis", context.selection.hypothesis},
       {"probe_frame", context.probe != nullptr ? context.probe->frame : -1},
       {"verdict", context.probe != nullptr ? context.probe->verdict_text : ""},
       {"relations", context.analysis != nullptr && context.analysis->relations
                         ? static_cast<int>(context.analysis->relations->size())
                         : -1},
       {"history_of", context.history != nullptr ? context.history->object.value : -1},
       {"map_tab", map_tab_},
       {"details_tab", object_tab_},
       {"follow", context.follow},
       {"look_through", context.look_through},
       {"presenting", presenter_.active()},
       {"shot", presenter_.shot()},
       {"image_zoom", viewport_.zoom},
       {"scene_renders", scene_->renders()},
       {"camera",
        {{"azimuth_deg", camera.azimuth_rad * kDegPerRad},
         {"elevation_deg", camera.elevation_rad * kDegPerRad},
         {"distance_m", camera.distance_m},
         {"parallel", camera.parallel},
         {"focus",
          {camera.focus_in_world.x(), camera.focus_in_world.y(), camera.focus_in_world.z()}}}},
       {"layout", RatiosToJson(ratios_)},
       {"maximized", context.maximized},
       {"hidden_panels", context.hidden_panels},
       {"own_layouts", context.own_layouts},
       {"compact_tab", compact_tab_},
       {"confirmed_only", context.confirmed_only},
       {"lacks_poses", context.lacks_poses},
       {"source", context.source},
       {"models", with_.models},
       {"recording", playback.recording},
       {"edges", playback.edges},
       {"detector", playback.detector},
       {"networks_sheet", networks_sheet_.is_open()},
       {"batch_sheet", batch_sheet_.is_open()},
       {"reopening", context.reopening != nullptr ? context.reopening->message : ""}});
  if (const NetworksView* networks = context.networks.get()) {
    const NetworkFile& file = networks->file;
    state.update({{"networks.file_known", file.known},
                  {"networks.file_is", file.what},
                  {"networks.file_guessed", file.guessed},
                  {"networks.file_problem", file.problem}});
  }
  if (const auto batch = batches_.View()) {
    state["batch.runs"] = batch->view.table.runs.size();
    state["batch.problem"] = batch->problem;
  }
  state["image_views"] = views_->Save(context);
  AddWhatIfState(context, fork_sheet_, state);
  for (const Bookmark& bookmark : context.bookmarks)
    state["bookmarks"].push_back({{"frame", bookmark.frame}, {"note", bookmark.note}});
  for (const Panel* panel : panels_) state["panels"][panel->id()] = panel->SaveState();
}

void InspectWorkspace::SaveSettings(const FrameContext& context, nlohmann::json& settings) const {
  settings["layout"] = RatiosToJson(ratios_);
  settings["hidden_panels"] = context.hidden_panels;
  settings["own_layouts"] = arrangements_.Save();
  settings["confirmed_only"] = context.confirmed_only;
  settings["details_tab"] = object_tab_;
  settings["image_views"] = views_->Save(context);
  for (const Panel* panel : panels_) settings["panels"][panel->id()] = panel->SaveState();
}

void InspectWorkspace::LoadSettings(const nlohmann::json& settings, FrameContext& context) {
  RatiosFromJson(KeptObject(settings, "layout"), ratios_);
  context.hidden_panels = KeptValue(settings, "hidden_panels", context.hidden_panels);
  context.confirmed_only = KeptValue(settings, "confirmed_only", context.confirmed_only);
  arrangements_.Load(KeptObject(settings, "own_layouts"));
  context.own_layouts = arrangements_.own_names();
  const nlohmann::json panels = KeptObject(settings, "panels");
  for (Panel* panel : panels_) panel->LoadState(KeptObject(panels, panel->id()));
  views_->Load(KeptObject(settings, "image_views"), context);
  object_tab_ = std::min(KeptValue(settings, "details_tab", object_tab_),
                         PanelsAt(PanelPlace::kAboutObject).size() - 1);
  if (options_.layout == nullptr) return;
  for (Panel* panel : panels_) {
    if (options_.layout->states.contains(panel->id()))
      panel->LoadState(options_.layout->states.at(panel->id()));
  }
}

}  // namespace plumbline
