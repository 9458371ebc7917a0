// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/framework/shortcuts.h"
#include "ui/framework/widgets.h"
#include "ui/panels/panels.h"

namespace plumbline {
namespace {

std::string SpeedName(double speed) {
  return speed > 0 ? fmt::format("{:g} \u00d7", speed) : "as fast as it goes";
}

std::string TimeName(double seconds) {
  const int minutes = static_cast<int>(seconds / 60);
  return fmt::format("{}:{:05.2f}", minutes, seconds - 60 * minutes);
}

class TimelinePanel : public Panel {
 public:
  const char* Id() const override { return "timeline"; }
  const char* Title() const override { return ""; }
  const char* Help() const override { return "Where in the sequence the window is."; }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    const PlaybackView& playback = *context.playback;
    const int last =
        context.sequence != nullptr ? std::max(0, context.sequence->num_frames - 1) : 0;
    ImGui::BeginDisabled(context.sequence == nullptr);
    DrawButtons(context, sink);
    ImGui::SameLine(0, context.Scaled(16));
    DrawNumbers(context, last);
    DrawSpeed(context, sink);
    DrawTrack(context, playback, last, sink);
    ImGui::EndDisabled();
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

  static void DrawNumbers(const FrameContext& context, int last) {
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + context.Scaled(7));
    const double rate = context.sequence != nullptr ? context.sequence->rate_hz : 30;
    ImGui::PushFont(context.fonts.strong);
    ImGui::Text("Frame %d", context.playback->frame);
    ImGui::PopFont();
    ImGui::SameLine(0, context.Scaled(6));
    DimText("of %d", last);
    Tooltip(context, "Frames count from 0.");
    ImGui::SameLine(0, context.Scaled(18));
    ImGui::TextUnformatted(TimeName(context.playback->frame / rate).c_str());
    ImGui::SameLine(0, context.Scaled(6));
    DimText("of %s min", TimeName(last / rate).c_str());
  }

  static void DrawSpeed(const FrameContext& context, CommandSink& sink) {
    const float width = context.Scaled(150);
    ImGui::SameLine(0, context.Scaled(18));
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - context.Scaled(3));
    const ImVec2 label = ImGui::CalcTextSize("Speed");
    AlignRight(width + label.x + context.Scaled(8));
    ImGui::AlignTextToFramePadding();
    DimText("Speed");
    ImGui::SameLine(0, context.Scaled(8));
    ImGui::SetNextItemWidth(width);
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

  void DrawTrack(const FrameContext& context, const PlaybackView& playback, int last,
                 CommandSink& sink) {
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const ImVec2 low = ImGui::GetCursorScreenPos();
    ImGui::InvisibleButton("timeline.track", {std::max(1.0f, room.x), std::max(1.0f, room.y)});
    LogItem(context, "timeline.track");
    const float pad = context.Scaled(7), width = room.x - 2 * pad;
    const float middle = low.y + 0.62f * room.y, half = context.Scaled(3);
    const auto x_of = [&](int frame) {
      return low.x + pad +
             width * static_cast<float>(last > 0 ? std::clamp(frame, 0, last) : 0) /
                 static_cast<float>(std::max(1, last));
    };
    const float share = std::clamp((ImGui::GetIO().MousePos.x - low.x - pad) / width, 0.0f, 1.0f);
    const int under_mouse = static_cast<int>(std::lround(share * static_cast<float>(last)));
    if (ImGui::IsItemActive() && under_mouse != dragged_to_) {
      dragged_to_ = under_mouse;
      sink.Post(SeekCommand{under_mouse});
    }
    if (!ImGui::IsItemActive()) dragged_to_ = -1;
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.AddRectFilled({low.x + pad, middle - half}, {low.x + pad + width, middle + half},
                       colors::kInset, half);
    const int newest = std::max(playback.newest_mapped_frame, 0);
    draw.AddRectFilled({low.x + pad, middle - half}, {x_of(newest), middle + half},
                       colors::kControlHovered, half);
    draw.AddRectFilled({low.x + pad, middle - half}, {x_of(playback.frame), middle + half},
                       colors::kAccent, half);
    if (playback.seek_target) {
      draw.AddCircle({x_of(*playback.seek_target), middle}, context.Scaled(6), colors::kAccent, 0,
                     context.Scaled(1.5));
    }
    DrawEvents(context, playback, x_of, middle - context.Scaled(9));
    draw.AddCircleFilled({x_of(playback.frame), middle}, context.Scaled(7), IM_COL32_WHITE);
    if (ImGui::IsItemHovered() && context.sequence != nullptr)
      DrawHint(context, playback, under_mouse, last);
  }

  template <typename XOf>
  static void DrawEvents(const FrameContext& context, const PlaybackView& playback, const XOf& x_of,
                         float y) {
    const float size = context.Scaled(4);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    for (const FrameEvent& event : *playback.events) {
      const float x = x_of(event.frame);
      const ImU32 color = EventColor(event.event.kind);
      draw.AddTriangleFilled({x - size, y - 1.5f * size}, {x + size, y - 1.5f * size}, {x, y},
                             color);
    }
  }

  static void DrawHint(const FrameContext& context, const PlaybackView& playback, int frame,
                       int last) {
    const int reach = std::max(1, last / 150);
    ImGui::BeginTooltip();
    ImGui::Text("Frame %d, %s min", frame, TimeName(frame / context.sequence->rate_hz).c_str());
    if (frame > playback.newest_mapped_frame) DimText("not mapped yet: a click maps up to here");
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
};

}  // namespace

std::unique_ptr<Panel> MakeTimelinePanel() { return std::make_unique<TimelinePanel>(); }

}  // namespace plumbline
