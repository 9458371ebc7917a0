// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timeline_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/files/kept_value.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/timeline/timeline_controls.h"
#include "ui/inspect/timeline/timeline_lanes.h"
#include "ui/inspect/timeline/timeline_plot.h"
#include "ui/inspect/timeline/timeline_track.h"

namespace plumbline {
namespace {

constexpr double kLabelWidth = 150;  ///< Left of the track.

class TimelinePanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    const int last =
        context.sequence != nullptr ? std::max(0, context.sequence->num_frames - 1) : 0;
    ImGui::BeginDisabled(context.sequence == nullptr);
    controls_.Draw(context, last, sink);
    DrawTrack(context, last, sink);
    ImGui::EndDisabled();
  }

  nlohmann::json SaveState() const override {
    return {{"plot", controls_.plotted().id}, {"all_truths", controls_.all_truths()}};
  }
  void LoadState(const nlohmann::json& json) override {
    controls_.Plot(KeptValue(json, "plot", std::string()));
    controls_.ShowAllTruths(KeptValue(json, "all_truths", controls_.all_truths()));
  }

 private:
  void DrawTrack(const FrameContext& context, int last, CommandSink& sink) {
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const ImVec2 corner = ImGui::GetCursorScreenPos();
    const float left = corner.x + context.Scaled(kLabelWidth);
    ImGui::SetCursorScreenPos({left, corner.y});
    ImGui::InvisibleButton("timeline.track",
                           {std::max(1.0f, corner.x + room.x - left), std::max(1.0f, room.y)},
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
    LogItem(context, "timeline.track");
    const float pad = context.Scaled(6);
    TimeAxis axis{left + pad, std::max(left + pad + 1, corner.x + room.x - pad), 0, 1};
    Zoom(last, axis);
    Seek(axis, last, sink);
    lanes_.Update(context, controls_.all_truths());
    const TimelineRows rows = PlanRows(context, corner.y, corner.y + room.y, lanes_.size());
    DrawRuler(context, axis, rows.ruler, rows.bar);
    if (rows.bar > rows.thumbnails) DrawThumbnails(context, axis, rows.thumbnails, rows.bar);
    DrawPlayed(context, axis, rows.bar, rows.lanes);
    if (rows.end > rows.plot)
      DrawPlot(context, axis, corner.x, rows.plot, rows.end, controls_.plotted());
    const bool hovered = ImGui::IsItemHovered() && context.sequence != nullptr;
    lanes_.Draw(context, axis, corner.x, rows.lanes, rows.plot, sink);
    DrawOptionMarks(context, axis, rows);
    DrawPlayhead(context, axis, rows);
    if (!hovered) return;
    PutTooltipBeside(context, {axis.x0, rows.ruler}, {axis.x1, rows.end});
    DrawHint(context, axis, std::clamp(UnderMouse(axis), 0, last));
  }

  static void DrawPlayhead(const FrameContext& context, const TimeAxis& axis,
                           const TimelineRows& rows) {
    const float x = axis.XOf(context.playback->frame);
    if (x < axis.x0 - 1 || x > axis.x1 + 1) return;
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.AddLine({x, rows.ruler}, {x, rows.end}, WithAlpha(colors::kText, 0.7),
                 context.Scaled(1.5));
    draw.AddCircleFilled({x, 0.5f * (rows.bar + rows.lanes)}, context.Scaled(6), colors::kText);
  }

  static int UnderMouse(const TimeAxis& axis) {
    return static_cast<int>(std::lround(axis.FrameAt(ImGui::GetIO().MousePos.x)));
  }

  /// Wheel zooms about the mouse, right drag moves, double click shows all.
  void Zoom(int last, TimeAxis& axis) {
    const double all = std::max(1, last);
    if (last != zoomed_of_) {
      zoomed_of_ = last;
      zoom_ = 1;
      start_ = 0;
    }
    const ImGuiIO& io = ImGui::GetIO();
    const double width = axis.x1 - axis.x0;
    const double at = (io.MousePos.x - axis.x0) / width;
    if (ImGui::IsItemHovered() && io.MouseWheel != 0) {
      const double before = zoom_;
      zoom_ = std::clamp(zoom_ * std::pow(1.25, io.MouseWheel), 1.0, std::max(1.0, all / 8));
      start_ += at * all * (1 / before - 1 / zoom_);
    }
    if (ImGui::IsItemActive() && ImGui::IsMouseDown(ImGuiMouseButton_Right))
      start_ -= io.MouseDelta.x / width * all / zoom_;
    if (ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) zoom_ = 1;
    start_ = std::clamp(start_, 0.0, all - all / zoom_);
    axis.first = start_;
    axis.last = start_ + all / zoom_;
  }

  void Seek(const TimeAxis& axis, int last, CommandSink& sink) {
    const bool pressed = ImGui::IsItemActive() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    const int frame = std::clamp(UnderMouse(axis), 0, last);
    if (pressed && frame != dragged_to_) {
      dragged_to_ = frame;
      sink.Post(SeekCommand{frame});
    }
    if (!pressed) dragged_to_ = -1;
  }

  static void DrawHint(const FrameContext& context, const TimeAxis& axis, int frame) {
    const PlaybackView& playback = context.shown_playback();
    const int reach = std::max(1, static_cast<int>((axis.last - axis.first) / 150));
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(context.Scaled(560));
    ImGui::Text("Frame %d, %s min", frame, TimeName(frame / context.sequence->rate_hz).c_str());
    if (frame > playback.newest_mapped_frame) DimText("not mapped yet: a click maps up to here");
    for (const Bookmark& bookmark : context.bookmarks) {
      if (std::abs(bookmark.frame - frame) > reach) continue;
      ImGui::PushStyleColor(ImGuiCol_Text, colors::kWarning);
      ImGui::Text("%d: bookmark", bookmark.frame);
      ImGui::PopStyleColor();
      ImGui::SameLine();
      DimText("%s", bookmark.note.c_str());
    }
    int shown = 0;
    for (const FrameEvent& event : *playback.events) {
      if (std::abs(event.frame - frame) > reach || ++shown > 6) continue;
      ImGui::PushStyleColor(ImGuiCol_Text, EventColor(event.event.kind));
      ImGui::Text("%d: %s", event.frame, InWords(NameOf(event.event.kind)).c_str());
      ImGui::PopStyleColor();
      ImGui::SameLine();
      if (event.event.object.value > 0)
        DimText("#%d  %s", event.event.object.value, event.event.text.c_str());
      else
        DimText("%s", event.event.text.c_str());
    }
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
  }

  int dragged_to_ = -1;
  TimelineControls controls_;
  TimelineLanes lanes_;
  double zoom_ = 1, start_ = 0;  ///< Part of time that shows: a zoomth, from this frame.
  int zoomed_of_ = -1;
};

}  // namespace

std::unique_ptr<Panel> MakeTimelinePanel() { return std::make_unique<TimelinePanel>(); }

}  // namespace plumbline
