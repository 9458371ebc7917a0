// SPDX-License-Identifier: Apache-2.0
#include "ui/common/frame_bars.h"

#include <fmt/format.h>

#include <cstring>
#include <vector>

#include "ui/annotate/annotate_actions.h"
#include "ui/annotate/annotate_panels.h"
#include "ui/framework/shortcuts.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

/// A plumb line: a cord with its bob.
void DrawLogo(ImVec2 center, float size) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float top = center.y - size;
  draw.AddLine({center.x, top}, {center.x, center.y}, colors::kDimText, 1.5f);
  draw.AddTriangleFilled({center.x - 0.5f * size, center.y - 0.1f * size},
                         {center.x + 0.5f * size, center.y - 0.1f * size},
                         {center.x, center.y + size}, colors::kAccent);
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
  switch (playback.state) {
    case PlaybackState::kFailed:
      return playback.message;
    case PlaybackState::kFinished:
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
    const std::string eta =
        playback.frames_per_second > 0
            ? fmt::format(", about {:.0f} s", missing / playback.frames_per_second)
            : "";
    return fmt::format("Mapping up to frame {}: {} to go{}{}", *playback.seek_target, missing, eta,
                       rate);
  }
  if (playback.mapping)
    return fmt::format("Mapping goes on: frame {} of {}. N shows the newest.",
                       playback.newest_mapped_frame, last);
  if (playback.recorded) return "Paused. Space plays the recording.";
  return fmt::format("Paused. Mapped up to frame {}; Space goes on.", playback.newest_mapped_frame);
}

/// A workspace's name; the one that shows is underlined.
void DrawTab(const FrameContext& context, const LayoutRect& bar, const char* name,
             const char* label, WorkspaceId id, const char* help, CommandSink& sink) {
  const bool shown = context.workspace == id;
  const ImVec2 low = ImGui::GetCursorScreenPos();
  ImGui::PushStyleColor(ImGuiCol_Text, shown ? colors::kText : colors::kDimText);
  ImGui::TextUnformatted(label);
  ImGui::PopStyleColor();
  LogItem(context, name);
  Tooltip(context, help);
  if (ImGui::IsItemClicked()) sink.Post(SwitchWorkspaceCommand{id == WorkspaceId::kAnnotate});
  if (!shown) return;
  ImGui::GetWindowDrawList()->AddRectFilled(
      {low.x, bar.high.y - context.Scaled(5)},
      {low.x + ImGui::CalcTextSize(label).x, bar.high.y - context.Scaled(3)}, colors::kAccent);
}

void DrawSequenceName(const FrameContext& context) {
  const std::string what = context.sequence != nullptr ? context.sequence->name : context.source;
  ImGui::TextUnformatted(what.c_str());
  if (context.sequence == nullptr) return;
  Tooltip(context, context.sequence->path);
  ImGui::SameLine(0, context.Scaled(12));
  DimText("%d frames, %d \u00d7 %d px, %g Hz%s", context.sequence->num_frames,
          context.sequence->image_width, context.sequence->image_height, context.sequence->rate_hz,
          context.playback->recorded ? ", recorded run" : "");
}

}  // namespace

void DrawTopBar(const FrameContext& context, const LayoutRect& rect, CommandSink& sink) {
  const float middle = 0.5f * (rect.low.y + rect.high.y);
  const float line = ImGui::GetTextLineHeight();
  DrawLogo({rect.low.x + context.Scaled(24), middle}, context.Scaled(10));
  ImGui::SetCursorScreenPos({rect.low.x + context.Scaled(42), middle - 0.5f * line});
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted("Plumbline");
  ImGui::PopFont();
  ImGui::SameLine(0, context.Scaled(24));
  DrawTab(context, rect, "top.inspect", "Inspect", WorkspaceId::kInspect,
          "Workspace: play a sequence through the mapper, or a recorded run, and see what it sees "
          "and believes.",
          sink);
  ImGui::SameLine(0, context.Scaled(16));
  DrawTab(context, rect, "top.annotate", "Annotate", WorkspaceId::kAnnotate,
          "Workspace: place models in a scan, to make the truth that maps are judged by.", sink);
  ImGui::SameLine(0, context.Scaled(24));
  if (context.workspace == WorkspaceId::kAnnotate) {
    const float buttons = 2 * (ImGui::GetFrameHeight() + context.Scaled(4)) + context.Scaled(26);
    DrawProjectBar(
        context,
        {{ImGui::GetCursorScreenPos().x, rect.low.y}, {rect.high.x - buttons, rect.high.y}}, sink);
  } else {
    DrawSequenceName(context);
  }
  const float button = ImGui::GetFrameHeight() + context.Scaled(4);
  ImGui::SetCursorScreenPos(
      {rect.high.x - 2 * button - context.Scaled(14), middle - 0.5f * button});
  if (IconButton(context, "top.screenshot", Icon::kCamera, false,
                 "Save a picture of the window (F12)"))
    sink.Post(ScreenshotCommand{});
  ImGui::SameLine(0, context.Scaled(4));
  if (IconButton(context, "top.help", Icon::kHelp, false, "Keys and mouse (F1 or ?)"))
    sink.Post(ShowHelpCommand{true});
}

void DrawStatusBar(const FrameContext& context, const LayoutRect& rect, const std::string& note) {
  const float y = 0.5f * (rect.low.y + rect.high.y) - 0.5f * context.fonts.small->FontSize;
  const bool annotates = context.workspace == WorkspaceId::kAnnotate;
  bool failed = context.playback->state == PlaybackState::kFailed;
  std::string status = annotates ? AnnotationStatus(context, failed) : StatusText(context);
  if (const ForkView* fork = context.fork.get();
      fork != nullptr && fork->state == ForkState::kRunning)
    status += fmt::format("  \u00b7  Fork: {} of {}", fork->done, fork->total);
  const std::string right = fmt::format("window {:.1f} ms  \u00b7  3-D {:.0f} ms  \u00b7  {}",
                                        context.window_ms, context.scene_ms, context.renderer);
  const float right_width =
      context.fonts.small->CalcTextSizeA(context.fonts.small->FontSize, 1e6f, 0, right.c_str()).x;
  const float right_x = rect.high.x - right_width - context.Scaled(14);
  const bool both = rect.width() > context.Scaled(900);
  ImGui::PushClipRect(rect.low, {both ? right_x - context.Scaled(10) : rect.high.x, rect.high.y},
                      true);
  ImGui::SetCursorScreenPos({rect.low.x + context.Scaled(14), y});
  const std::string text = note.empty() || failed ? status : note;
  SmallText(context, failed ? colors::kBad : colors::kDimText, "%s", text.c_str());
  Tooltip(context, text);
  ImGui::PopClipRect();
  if (!both) return;
  ImGui::SetCursorScreenPos({right_x, y});
  SmallText(context, colors::kFaint, "%s", right.c_str());
}

void DrawHelpSheet(const FrameContext& context, CommandSink& sink) {
  constexpr const char* kMouse[][2] = {{"Left drag", "Turn the map; move a zoomed image"},
                                       {"Right or middle drag", "Move the map"},
                                       {"Shift + left drag", "Move the map"},
                                       {"Wheel", "Zoom the map or the images"},
                                       {"Double click", "Turn about a point; show the whole image"},
                                       {"Click", "Select an object"},
                                       {"Click on an image's title", "Choose what it shows"},
                                       {"Right click on a title", "Save the panel as PNG"}};
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos({0.5f * display.x, 0.5f * display.y}, ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowBgAlpha(0.98f);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, context.Scaled(10));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(26), context.Scaled(20)});
  ImGui::PushStyleColor(ImGuiCol_WindowBg, colors::kSheet);
  ImGui::Begin("help", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                   ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted("Keys and mouse");
  ImGui::PopFont();
  ImGui::Dummy({0, context.Scaled(4)});
  constexpr auto kFlags = ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_NoHostExtendX;
  if (ImGui::BeginTable("help.table", 2, kFlags)) {
    const char* group = "";
    const bool annotates = context.workspace == WorkspaceId::kAnnotate;
    std::vector<Shortcut> shortcuts;
    if (annotates) {
      shortcuts.assign(AnnotateShortcuts().begin(), AnnotateShortcuts().end());
    }
    for (const Shortcut& shortcut : Shortcuts()) {
      const bool shown = !annotates || std::strcmp(shortcut.group, "Playback") != 0;
      if (*shortcut.keys != '\0' && shown) shortcuts.push_back(shortcut);
    }
    for (const Shortcut& shortcut : shortcuts) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      if (std::strcmp(group, shortcut.group) != 0) {
        group = shortcut.group;
        SmallText(context, colors::kAccent, "%s", group);
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
      }
      ImGui::TextUnformatted(shortcut.keys);
      ImGui::TableNextColumn();
      DimText("%s", shortcut.meaning);
    }
    ImGui::EndTable();
  }
  ImGui::SameLine(0, context.Scaled(36));
  if (ImGui::BeginTable("help.mouse", 2, kFlags)) {
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    SmallText(context, colors::kAccent, "Mouse");
    for (const auto& row : kMouse) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(row[0]);
      ImGui::TableNextColumn();
      DimText("%s", row[1]);
    }
    ImGui::EndTable();
  }
  ImGui::Dummy({0, context.Scaled(4)});
  if (Button(context, "help.close", "Close", "Esc closes it, too."))
    sink.Post(ShowHelpCommand{false});
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

}  // namespace plumbline
