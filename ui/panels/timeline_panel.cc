// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "ui/framework/shortcuts.h"
#include "ui/framework/widgets.h"
#include "ui/panels/panels.h"
#include "ui/panels/timeline_plot.h"
#include "ui/panels/timeline_track.h"

namespace plumbline {
namespace {

constexpr double kLabelWidth = 96;  ///< Left of the track.

std::string SpeedName(double speed) {
  return speed > 0 ? fmt::format("{:g} \u00d7", speed) : "as fast as it goes";
}

class TimelinePanel : public Panel {
 public:
  const char* Id() const override { return "timeline"; }
  const char* Title() const override { return ""; }
  const char* Help() const override { return "Where in the sequence the window is."; }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    const int last =
        context.sequence != nullptr ? std::max(0, context.sequence->num_frames - 1) : 0;
    ImGui::BeginDisabled(context.sequence == nullptr);
    DrawButtons(context, sink);
    ImGui::SameLine(0, context.Scaled(16));
    DrawNumbers(context, last, sink);
    DrawRange(context, sink);
    DrawBookmarks(context, sink);
    DrawChoices(context, sink);
    DrawTrack(context, last, sink);
    ImGui::EndDisabled();
  }

  nlohmann::json SaveState() const override { return {{"plot", PlottedQuantities()[plot_].id}}; }
  void LoadState(const nlohmann::json& json) override {
    const std::string id = json.value("plot", std::string());
    for (std::size_t i = 0; i < PlottedQuantities().size(); ++i) {
      if (id == PlottedQuantities()[i].id) plot_ = i;
    }
  }

 private:
  static void DrawButtons(const FrameContext& context, CommandSink& sink) {
    const bool playing = context.playback->state == PlaybackState::kPlaying;
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {context.Scaled(3), context.Scaled(4)});
    if (IconButton(context, "timeline.first", Icon::kFirst, false, "First frame (Home)"))
      sink.Post(SeekCommand{0});
    ImGui::SameLine();
    if (IconButton(context, "timeline.back", Icon::kStepBack, false,
                   "One frame back (Left; with Shift ten)")) {
      sink.Post(StepCommand{ImGui::GetIO().KeyShift ? -10 : -1});
    }
    ImGui::SameLine();
    if (IconButton(context, "timeline.play", playing ? Icon::kPause : Icon::kPlay, true,
                   playing ? "Pause (Space)"
                           : "Play on; past the newest frame the mapper goes on (Space)")) {
      sink.Post(TogglePlayCommand{});
    }
    ImGui::SameLine();
    if (IconButton(context, "timeline.forward", Icon::kStepForward, false,
                   "One frame on (Right; with Shift ten)")) {
      sink.Post(StepCommand{ImGui::GetIO().KeyShift ? 10 : 1});
    }
    ImGui::SameLine();
    if (IconButton(context, "timeline.last", Icon::kLast, false, "Newest mapped frame (End)")) {
      sink.Post(SeekCommand{context.playback->newest_mapped_frame});
    }
    ImGui::PopStyleVar();
  }

  void DrawNumbers(const FrameContext& context, int last, CommandSink& sink) {
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + context.Scaled(4));
    const double rate = context.sequence != nullptr ? context.sequence->rate_hz : 30;
    ImGui::AlignTextToFramePadding();
    DimText("Frame");
    ImGui::SameLine(0, context.Scaled(6));
    ImGui::SetNextItemWidth(context.Scaled(62));
    if (context.ask_frame) ImGui::SetKeyboardFocusHere();
    int frame = context.playback->frame;
    if (ImGui::InputInt("##timeline.frame", &frame, 0, 0, ImGuiInputTextFlags_EnterReturnsTrue)) {
      sink.Post(SeekCommand{std::clamp(frame, 0, last)});
    }
    LogItem(context, "timeline.frame");
    Tooltip(context, "Type a frame number and press Enter (G). Frames count from 0.");
    ImGui::SameLine(0, context.Scaled(6));
    DimText("of %d", last);
    ImGui::SameLine(0, context.Scaled(16));
    ImGui::TextUnformatted(TimeName(context.playback->frame / rate).c_str());
    ImGui::SameLine(0, context.Scaled(6));
    DimText("of %s min", TimeName(last / rate).c_str());
  }

  static void DrawRange(const FrameContext& context, CommandSink& sink) {
    const PlaybackView& playback = *context.playback;
    ImGui::SameLine(0, context.Scaled(20));
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + context.Scaled(1));
    if (!playback.recorded) {
      bool follow = playback.follow;
      const bool behind = playback.mapping && !follow;
      if (Toggle(context, "timeline.live", behind ? "Back to live" : "Live", follow,
                 behind
                     ? "The mapper goes on meanwhile: back to its newest frame (N)."
                     : "Maps on as fast as it goes and shows the newest frame. Look back whenever "
                       "you like: the mapper goes on (N)."))
        sink.Post(FollowNewestCommand{follow});
      ImGui::SameLine(0, context.Scaled(3));
    }
    bool loop = playback.loop;
    if (Toggle(context, "timeline.loop", "Loop", loop, "Playing starts again at the end (L)."))
      sink.Post(SetLoopCommand{loop});
    ImGui::SameLine(0, context.Scaled(3));
    bool begin = playback.range_begin.has_value(), end = playback.range_end.has_value();
    if (Toggle(context, "timeline.in", "In", begin,
               "Playing keeps to what lies after this frame (I). Again: from the first frame."))
      sink.Post(SetRangeCommand{begin ? std::optional(playback.frame) : std::nullopt,
                                playback.range_end});
    ImGui::SameLine(0, context.Scaled(3));
    if (Toggle(context, "timeline.out", "Out", end,
               "Playing keeps to what lies before this frame (O). Again: to the last frame."))
      sink.Post(SetRangeCommand{playback.range_begin,
                                end ? std::optional(playback.frame) : std::nullopt});
  }

  void DrawBookmarks(const FrameContext& context, CommandSink& sink) {
    ImGui::SameLine(0, context.Scaled(12));
    bool open = false;
    const std::string label = context.bookmarks.empty()
                                  ? "Bookmarks"
                                  : fmt::format("Bookmarks ({})", context.bookmarks.size());
    if (Toggle(context, "timeline.bookmarks", label.c_str(), open,
               "Frames to come back to, with notes; kept beside the run (B marks this frame).")) {
      ImGui::OpenPopup("bookmarks");
      note_[0] = '\0';
    }
    if (!ImGui::BeginPopup("bookmarks")) return;
    ImGui::SetNextItemWidth(context.Scaled(240));
    if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
    const bool entered =
        ImGui::InputTextWithHint("##note", "note for this frame", note_, sizeof(note_),
                                 ImGuiInputTextFlags_EnterReturnsTrue);
    LogItem(context, "timeline.note");
    ImGui::SameLine();
    if (Button(context, "timeline.mark", "Mark", "Keeps this frame and the note.") || entered) {
      sink.Post(BookmarkCommand{context.playback->frame, note_});
      ImGui::CloseCurrentPopup();
    }
    if (ImGui::IsKeyPressed(keys::kEscape, false)) ImGui::CloseCurrentPopup();
    if (context.bookmarks.empty()) DimText("No bookmarks yet.");
    for (const Bookmark& bookmark : context.bookmarks) {
      ImGui::PushID(bookmark.frame);
      if (ImGui::Selectable(fmt::format("{:>6}   {}", bookmark.frame, bookmark.note).c_str(), false,
                            0, {context.Scaled(270), 0}))
        sink.Post(SeekCommand{bookmark.frame});
      ImGui::SameLine();
      if (ImGui::SmallButton("\u00d7")) sink.Post(RemoveBookmarkCommand{bookmark.frame});
      Tooltip(context, "Forget this bookmark.");
      ImGui::PopID();
    }
    ImGui::EndPopup();
  }

  /// What is plotted, and the speed, from the right edge.
  void DrawChoices(const FrameContext& context, CommandSink& sink) {
    const float width = context.Scaled(130), plot_width = context.Scaled(150);
    const std::string value = ValueNow(context, PlottedQuantities()[plot_]);
    const float value_width = context.Scaled(90);
    ImGui::SameLine(0, context.Scaled(12));
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - context.Scaled(1));
    const float labels = ImGui::CalcTextSize("Speed").x + ImGui::CalcTextSize("Plot").x;
    const float all = width + plot_width + value_width + labels + context.Scaled(50);
    const bool fits = ImGui::GetContentRegionAvail().x > all;
    AlignRight(fits ? all : width);
    if (fits) {
      DrawPlotChoice(context, plot_width);
      ImGui::SameLine(0, context.Scaled(8));
      const float x = ImGui::GetCursorPosX();
      ImGui::PushStyleColor(ImGuiCol_Text, ObjectColor(context.selection.object));
      ImGui::TextUnformatted(value.c_str());
      ImGui::PopStyleColor();
      ImGui::SameLine();
      ImGui::SetCursorPosX(x + value_width);
      ImGui::AlignTextToFramePadding();
      DimText("Speed");
      ImGui::SameLine(0, context.Scaled(8));
    }
    ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x);
    if (ImGui::BeginCombo("##timeline.speed", SpeedName(context.playback->speed).c_str())) {
      for (const double speed : PlaybackSpeeds()) {
        if (ImGui::Selectable(SpeedName(speed).c_str(), speed == context.playback->speed))
          sink.Post(SetSpeedCommand{speed});
      }
      ImGui::EndCombo();
    }
    LogItem(context, "timeline.speed");
    Tooltip(context,
            "Factor on the recorded rate. The mapper may be slower; then every frame is shown as "
            "it comes. ( [ and ] )");
  }

  void DrawPlotChoice(const FrameContext& context, float width) {
    ImGui::AlignTextToFramePadding();
    DimText("Plot");
    ImGui::SameLine(0, context.Scaled(8));
    ImGui::SetNextItemWidth(width);
    if (ImGui::BeginCombo("##timeline.plot", PlottedQuantities()[plot_].name)) {
      for (std::size_t i = 0; i < PlottedQuantities().size(); ++i) {
        if (ImGui::Selectable(PlottedQuantities()[i].name, i == plot_)) plot_ = i;
        Tooltip(context, PlottedQuantities()[i].help);
      }
      ImGui::EndCombo();
    }
    LogItem(context, "timeline.plot");
    Tooltip(context, std::string(PlottedQuantities()[plot_].help) +
                         " The selected object is bold; its value in this frame stands beside.");
  }

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
    if (events_ != context.playback->events || lane_for_ != context.selection.object) {
      events_ = context.playback->events;
      lane_for_ = context.selection.object;
      lanes_ = LanesOf(*events_, lane_for_);
    }
    const TrackRows rows = PlanRows(context, corner.y, corner.y + room.y, lanes_.size());
    DrawRuler(context, axis, rows.ruler, rows.bar);
    if (rows.bar > rows.thumbnails) DrawThumbnails(context, axis, rows.thumbnails, rows.bar);
    DrawPlayed(context, axis, rows.bar, rows.lanes);
    DrawLanes(context, axis, corner.x, rows.lanes, std::min(rows.plot, rows.end), lanes_);
    if (rows.end > rows.plot)
      DrawPlot(context, axis, corner.x, rows.plot, rows.end, PlottedQuantities()[plot_]);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const float x = axis.XOf(context.playback->frame);
    if (x >= axis.x0 - 1 && x <= axis.x1 + 1) {
      draw.AddLine({x, rows.ruler}, {x, rows.end}, WithAlpha(colors::kText, 0.7),
                   context.Scaled(1.5));
      draw.AddCircleFilled({x, 0.5f * (rows.bar + rows.lanes)}, context.Scaled(6), colors::kText);
    }
    if (ImGui::IsItemHovered() && context.sequence != nullptr)
      DrawHint(context, axis, std::clamp(UnderMouse(axis), 0, last));
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
    const PlaybackView& playback = *context.playback;
    const int reach = std::max(1, static_cast<int>((axis.last - axis.first) / 150));
    ImGui::BeginTooltip();
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
      ImGui::Text("%d: %s", event.frame, EventName(event.event.kind));
      ImGui::PopStyleColor();
      ImGui::SameLine();
      if (event.event.object.value > 0)
        DimText("#%d  %s", event.event.object.value, event.event.text.c_str());
      else
        DimText("%s", event.event.text.c_str());
    }
    ImGui::EndTooltip();
  }

  int dragged_to_ = -1;
  std::size_t plot_ = 0;
  char note_[200] = "";
  double zoom_ = 1, start_ = 0;  ///< Part of time that shows: a zoomth, from this frame.
  int zoomed_of_ = -1;
  std::shared_ptr<const std::vector<FrameEvent>> events_;  ///< What lanes_ points into.
  ObjectId lane_for_;
  std::vector<ObjectLane> lanes_;
};

}  // namespace

std::unique_ptr<Panel> MakeTimelinePanel() { return std::make_unique<TimelinePanel>(); }

}  // namespace plumbline
