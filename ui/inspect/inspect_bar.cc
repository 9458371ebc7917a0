// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/inspect_bar.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "ui/files/layout_ratios.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/networks_sheet.h"
#include "ui/inspect/panel_table.h"

namespace plumbline {
namespace {

/// Of a recording that is played by the clock.
std::string LiveText(const PlaybackView& playback, const std::string& rate) {
  const LiveReport& live = *playback.live;
  const std::string fares = fmt::format("{} of {} frames mapped as they came, {} passed over",
                                        live.done, live.came(), live.passed_over);
  if (playback.state == PlaybackState::kFinished) return "At the end: " + fares + ".";
  if (playback.state == PlaybackState::kPlaying || playback.mapping)
    return fmt::format("Live, frame {}: {}; {:.0f} ms old when mapped{}", playback.frame, fares,
                       live.done_age_ms, rate);
  return fmt::format("Paused; what comes now is passed over. Space goes on. So far {}.", fares);
}

/// Of a run that somebody else is mapping.
std::string GrowingText(const PlaybackView& playback, const std::string& rate) {
  if (playback.follow)
    return fmt::format("Following the run as it is mapped: frame {}{}", playback.frame, rate);
  const char* doing = playback.state == PlaybackState::kPlaying ? "Playing" : "Looking back at";
  return fmt::format("{} frame {}; the run is mapped up to {}, and goes on. N shows the newest.",
                     doing, playback.frame, playback.newest_mapped_frame);
}

std::string StatusText(const FrameContext& context) {
  const PlaybackView& playback = *context.playback;
  const std::string rate = playback.frames_per_second > 0 ? fmt::format("  \u00b7  {:.1f} frames/s",
                                                                        playback.frames_per_second)
                                                          : "";
  if (context.sequence == nullptr && context.source.empty()) return "Nothing is open.";
  if (context.sequence == nullptr) return playback.message.empty() ? "Opening" : playback.message;
  const int last = std::max(0, context.sequence->num_frames - 1);
  const bool at_newest = playback.frame >= playback.newest_mapped_frame;
  const char* doing = playback.recorded || !at_newest ? "Playing the recording" : "Mapping";
  if (playback.live && playback.state != PlaybackState::kFailed) return LiveText(playback, rate);
  if (playback.growing) return GrowingText(playback, rate);
  switch (playback.state) {
    case PlaybackState::kFailed:
      return playback.message;
    case PlaybackState::kFinished:
      if (playback.newest_mapped_frame < last)
        return fmt::format("At the end: the run has frames up to {} of {}.",
                           playback.newest_mapped_frame, last);
      return fmt::format("At the end: all {} frames are {}.", last + 1,
                         playback.recorded ? "recorded" : "mapped");
    case PlaybackState::kPlaying:
      if (playback.mapping && !playback.follow)
        return fmt::format("Playing frame {}; the mapper is at {} of {}{}", playback.frame,
                           playback.newest_mapped_frame, last, rate);
      return fmt::format("{} frame {} of {}{}", doing, playback.frame, last, rate);
    case PlaybackState::kPaused:
      break;
  }
  if (playback.seek_target) {
    const int missing = *playback.seek_target - playback.newest_mapped_frame;
    if (missing <= 0) return fmt::format("Going to frame {}", *playback.seek_target);
    const std::string eta =
        playback.frames_per_second > 0
            ? fmt::format(", about {:.0f} s", missing / playback.frames_per_second)
            : "";
    return fmt::format("Mapping up to frame {}: {} to go{}{}", *playback.seek_target, missing, eta,
                       rate);
  }
  if (playback.mapping)
    return fmt::format("Mapping continues: frame {} of {}. N shows the newest.",
                       playback.newest_mapped_frame, last);
  if (playback.recorded) return "Paused. Space plays the recording.";
  return fmt::format("Paused. Mapped up to frame {}; Space goes on.", playback.newest_mapped_frame);
}

/// Places the cursor for a switch in the bar; false where there is no room for it.
bool StartSwitch(const FrameContext& context, const LayoutRect& bar, const char* label) {
  ImGui::SameLine(0, context.Scaled(6));
  const float y =
      0.5f * (bar.low.y + bar.high.y) - 0.5f * (context.fonts.small->FontSize + context.Scaled(8));
  ImGui::SetCursorScreenPos({ImGui::GetCursorScreenPos().x, y});
  return ImGui::GetCursorScreenPos().x + ToggleWidth(context, label) <= bar.high.x;
}

}  // namespace

void DrawSequenceName(const FrameContext& context, const LayoutRect& bar) {
  const std::string what = context.sequence != nullptr ? context.sequence->name : context.source;
  const float switches =
      ToggleWidth(context, "Layout") + ToggleWidth(context, "Confirmed only") + context.Scaled(24);
  const float x = ImGui::GetCursorScreenPos().x, room = bar.high.x - x - switches;
  const float width = ImGui::CalcTextSize(what.c_str()).x;
  ImGui::PushClipRect(bar.low, {x + std::max(room, context.Scaled(60)), bar.high.y}, true);
  ImGui::TextUnformatted(what.c_str());
  ImGui::PopClipRect();
  if (context.sequence == nullptr) return;
  Tooltip(context, context.sequence->path);
  const SequenceView& sequence = *context.sequence;
  const char* kind = context.playback->growing    ? ", being mapped elsewhere"
                     : context.playback->recorded ? ", recorded run"
                                                  : "";
  const std::string more =
      fmt::format("{} frames, {} \u00d7 {} px, {:g} Hz{}", sequence.num_frames,
                  sequence.image_width, sequence.image_height, sequence.rate_hz, kind);
  if (width > room) ImGui::SetCursorScreenPos({x + room, bar.low.y});
  if (width > room) return ImGui::Dummy({0, 0});
  if (width + context.Scaled(12) + ImGui::CalcTextSize(more.c_str()).x > room) return;
  ImGui::SameLine(0, context.Scaled(12));
  DimText("%s", more.c_str());
}

void DrawNetworksButton(const FrameContext& context, const LayoutRect& bar, CommandSink& sink) {
  if (context.sequence == nullptr) return;
  const PlaybackView& playback = context.shown_playback();
  const std::string label = fmt::format("edges: {}  \u00b7  boxes: {}", NetworkName(playback.edges),
                                        NetworkName(playback.detector));
  if (!StartSwitch(context, bar, label.c_str())) return;
  bool on = false;
  if (Toggle(context, "top.networks", label.c_str(), on,
             "Which networks find edges and boxes; choose others."))
    sink.Post(AskNetworksCommand{});
}

void DrawConfirmedOnly(const FrameContext& context, const LayoutRect& bar, CommandSink& sink) {
  if (context.sequence == nullptr || !StartSwitch(context, bar, "Confirmed only")) return;
  bool on = context.confirmed_only;
  if (Toggle(context, "top.confirmed", "Confirmed only", on,
             "All views leave out objects that are not confirmed (the timeline: those that never "
             "were), but for the selected one (C)."))
    sink.Post(ConfirmedOnlyCommand{on});
}

void LayoutMenu::Draw(const FrameContext& context, const LayoutRect& bar, CommandSink& sink) {
  if (context.sequence == nullptr || !StartSwitch(context, bar, "Layout")) return;
  bool open = false;
  if (Toggle(context, "top.layout", "Layout", open,
             "How the panels are arranged, and which there are."))
    ImGui::OpenPopup("layouts");
  if (!ImGui::BeginPopup("layouts")) return;
  DrawPopup(context, sink);
  ImGui::EndPopup();
}

void LayoutMenu::DrawPopup(const FrameContext& context, CommandSink& sink) {
  DimText("Arrange as");
  for (const std::string_view name : kBuiltInLayouts) {
    if (ImGui::MenuItem(name.data())) sink.Post(ChooseLayoutCommand{std::string(name)});
    LogItem(context, fmt::format("layout.{}", name));
  }
  for (const std::string& name : context.own_layouts) {
    ImGui::PushID(name.c_str());
    if (ImGui::Selectable(name.c_str(), false, 0, {context.Scaled(190), 0}))
      sink.Post(ChooseLayoutCommand{name});
    LogItem(context, "layout.own." + name);
    ImGui::SameLine();
    if (ImGui::SmallButton("\u00d7")) sink.Post(ForgetLayoutCommand{name});
    LogItem(context, "layout.forget." + name);
    Tooltip(context, "Forget this arrangement.");
    ImGui::PopID();
  }
  ImGui::SetNextItemWidth(context.Scaled(150));
  const bool entered = ImGui::InputTextWithHint("##name", "name", name_, sizeof(name_),
                                                ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, "layout.name");
  ImGui::SameLine();
  if (Button(context, "layout.keep", "Keep", "Keeps the panels as they are now under this name.") ||
      entered) {
    sink.Post(KeepLayoutCommand{name_});
    name_[0] = '\0';
  }
  ImGui::Separator();
  DimText("Panels");
  for (const PanelEntry& entry : InspectPanels()) {
    if (!CanHide(entry) || (entry.is_there != nullptr && !entry.is_there(context))) continue;
    const bool hidden = context.hidden_panels.contains(entry.info.id);
    if (ImGui::Selectable(
            fmt::format("{}  {}", hidden ? "\u2013" : "\u2022", entry.info.title).c_str(), false,
            ImGuiSelectableFlags_DontClosePopups))
      sink.Post(HidePanelCommand{entry.info.id, !hidden});
    LogItem(context, fmt::format("layout.panel.{}", entry.info.id));
    Tooltip(context, hidden ? "Not shown; a click brings it back." : "A click hides it.");
  }
}

StatusLine InspectStatus(const FrameContext& context) {
  StatusLine line{StatusText(context), context.playback->state == PlaybackState::kFailed};
  if (const ForkView* fork = context.fork.get();
      fork != nullptr && fork->state == ForkState::kRunning)
    line.text += fmt::format("  \u00b7  Fork: {} of {}", fork->done, fork->total);
  if (const PlaybackView* next = context.reopening.get();
      next != nullptr && next->state != PlaybackState::kFailed)
    line.text += "  \u00b7  With other networks: " + next->message;
  return line;
}

}  // namespace plumbline
