// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timeline_controls.h"

#include <fmt/format.h>

#include <algorithm>

#include "ui/framework/widgets.h"
#include "ui/inspect/timeline/timeline_actions.h"
#include "ui/inspect/timeline/timeline_track.h"

namespace plumbline {
namespace {

std::string SpeedName(double speed) {
  return speed > 0 ? fmt::format("{:g} \u00d7", speed) : "as fast as it goes";
}

}  // namespace

void TimelineControls::Draw(const FrameContext& context, int last, CommandSink& sink) {
  DrawButtons(context, sink);
  ImGui::SameLine(0, context.Scaled(16));
  DrawNumbers(context, last, sink);
  DrawRange(context, sink);
  DrawBookmarks(context, sink);
  if (context.truths != nullptr) {
    ImGui::SameLine(0, context.Scaled(3));
    Toggle(context, "timeline.truth", "Truth", all_truths_,
           "A lane for every true object: where it shows (thin), where a box lies over it (above), "
           "and the object that it is paired with (thick). Off: only for those that were missed.");
  }
  DrawChoices(context, sink);
}

void TimelineControls::Plot(std::string_view id) {
  for (std::size_t i = 0; i < PlottedQuantities().size(); ++i) {
    if (id == PlottedQuantities()[i].id) plot_ = i;
  }
}

void TimelineControls::DrawButtons(const FrameContext& context, CommandSink& sink) {
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
                 "One frame forward (Right; with Shift ten)")) {
    sink.Post(StepCommand{ImGui::GetIO().KeyShift ? 10 : 1});
  }
  ImGui::SameLine();
  if (IconButton(context, "timeline.last", Icon::kLast, false, "Newest mapped frame (End)")) {
    sink.Post(SeekCommand{context.playback->newest_mapped_frame});
  }
  ImGui::PopStyleVar();
}

void TimelineControls::DrawNumbers(const FrameContext& context, int last, CommandSink& sink) {
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

void TimelineControls::DrawRange(const FrameContext& context, CommandSink& sink) {
  const PlaybackView& playback = *context.playback;
  ImGui::SameLine(0, context.Scaled(20));
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + context.Scaled(1));
  if (!playback.recorded || playback.growing) {
    bool follow = playback.follow;
    const bool behind = (playback.mapping || playback.growing) && !follow;
    if (Toggle(context, "timeline.live", behind ? "Back to live" : "Live", follow,
               behind ? "The mapper keeps running: back to its newest frame (N)."
               : playback.growing
                   ? "Shows the newest frame of the run that is being mapped. Look back whenever "
                     "you like (N)."
                   : "Maps as fast as it can and shows the newest frame. Look back whenever "
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
    sink.Post(
        SetRangeCommand{begin ? std::optional(playback.frame) : std::nullopt, playback.range_end});
  ImGui::SameLine(0, context.Scaled(3));
  if (Toggle(context, "timeline.out", "Out", end,
             "Playing keeps to what lies before this frame (O). Again: to the last frame."))
    sink.Post(
        SetRangeCommand{playback.range_begin, end ? std::optional(playback.frame) : std::nullopt});
}

void TimelineControls::DrawBookmarks(const FrameContext& context, CommandSink& sink) {
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
  const bool entered = ImGui::InputTextWithHint(
      "##note", "note for this frame", note_, sizeof(note_), ImGuiInputTextFlags_EnterReturnsTrue);
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
void TimelineControls::DrawChoices(const FrameContext& context, CommandSink& sink) {
  const float width = context.Scaled(130), plot_width = context.Scaled(150);
  const std::string value = ValueNow(context, PlottedQuantities()[plot_]);
  const float value_width = context.Scaled(105);
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
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float down = ImGui::GetStyle().FramePadding.y;  // to the line of the text beside
    const float chip = value.empty() ? 0.0f
                                     : DrawChip(context, *ImGui::GetWindowDrawList(),
                                                {at.x, at.y + down}, context.selection.object);
    ImGui::SetCursorScreenPos({at.x + chip, at.y});
    ImGui::TextUnformatted(value.c_str());
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

void TimelineControls::DrawPlotChoice(const FrameContext& context, float width) {
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

}  // namespace plumbline
