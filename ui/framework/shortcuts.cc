// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/shortcuts.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <map>
#include <string_view>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

constexpr std::array kShortcuts = {
    Shortcut{keys::kSpace, false, false, "Space", "Play or pause", "Playback"},
    Shortcut{keys::kRight, false, false, "\u2190  \u2192", "One frame back, on", "Playback"},
    Shortcut{keys::kLeft, false, false, "", "", ""},
    Shortcut{keys::kPeriod, false, false, "", "", ""},
    Shortcut{keys::kComma, false, false, "", "", ""},
    Shortcut{keys::kRight, true, false, "Shift + \u2190  \u2192", "Ten frames back, on",
             "Playback"},
    Shortcut{keys::kLeft, true, false, "", "", ""},
    Shortcut{keys::kHome, false, false, "Home  End", "First frame, newest mapped frame",
             "Playback"},
    Shortcut{keys::kEnd, false, false, "", "", ""},
    Shortcut{keys::kLeftBracket, false, false, "[  ]", "Slower, faster", "Playback"},
    Shortcut{keys::kRightBracket, false, false, "", "", ""},
    Shortcut{keys::kG, false, false, "G", "Go to a frame by number", "Playback"},
    Shortcut{keys::kL, false, false, "L", "Loop", "Playback"},
    Shortcut{keys::kN, false, false, "N", "Map on and follow the newest frame, or stop",
             "Playback"},
    Shortcut{keys::kI, false, false, "I  O", "Play only after, before this frame", "Playback"},
    Shortcut{keys::kO, false, false, "", "", ""},
    Shortcut{keys::kB, false, false, "B", "Bookmark this frame", "Playback"},
    Shortcut{keys::kV, false, false, "V", "This run or the other, where two are open", "Playback"},
    Shortcut{keys::kF5, false, false, "F5", "Demo mode: full screen with captions, until any key",
             "Playback"},
    Shortcut{keys::kF, false, false, "F", "Frame the selected object in 3-D", "View"},
    Shortcut{keys::kR, false, false, "R", "Reset the views", "View"},
    Shortcut{keys::kEscape, false, false, "Esc", "Clear the selection", "View"},
    Shortcut{'1', false, false, "1 .. 6", "Map from front, back, left, right, above, aslant",
             "View"},
    Shortcut{'2', false, false, "", "", ""},
    Shortcut{'3', false, false, "", "", ""},
    Shortcut{'4', false, false, "", "", ""},
    Shortcut{'5', false, false, "", "", ""},
    Shortcut{'6', false, false, "", "", ""},
    Shortcut{'0', false, false, "0", "Map through the camera", "View"},
    Shortcut{keys::kL, false, true, "Ctrl + L", "Light or dark theme", "View"},
    Shortcut{keys::kEqual, false, true, "Ctrl + \u2212  =", "Smaller, larger text", "View"},
    Shortcut{keys::kMinus, false, true, "", "", ""},
    Shortcut{keys::kP, false, true, "Ctrl + P", "Find anything: actions, objects, frames, files",
             "Window"},
    Shortcut{keys::kF12, false, false, "F12", "Save a picture of the window", "Window"},
    Shortcut{keys::kF1, false, false, "F1  ?", "This sheet", "Window"},
    Shortcut{keys::kSlash, true, false, "", "", ""},
    Shortcut{keys::kQ, false, true, "Ctrl + Q", "Quit", "Window"},
};

constexpr std::array kSpeeds = {0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 0.0};

double NextSpeed(double speed, int direction) {
  const auto found = std::find(kSpeeds.begin(), kSpeeds.end(), speed);
  const auto index = found == kSpeeds.end() ? 3 : std::distance(kSpeeds.begin(), found);
  return kSpeeds[static_cast<std::size_t>(
      std::clamp<std::ptrdiff_t>(index + direction, 0, std::ssize(kSpeeds) - 1))];
}

void PostShortcut(const Shortcut& shortcut, const FrameContext& context, bool help_shown,
                  CommandSink& sink) {
  const int stride = shortcut.shift ? 10 : 1;
  switch (shortcut.key) {
    case keys::kSpace:
      return sink.Post(TogglePlayCommand{});
    case keys::kRight:
    case keys::kPeriod:
      return sink.Post(StepCommand{stride});
    case keys::kLeft:
    case keys::kComma:
      return sink.Post(StepCommand{-stride});
    case keys::kHome:
      return sink.Post(SeekCommand{0});
    case keys::kEnd:
      return sink.Post(SeekCommand{context.playback->newest_mapped_frame});
    case keys::kLeftBracket:
      return sink.Post(SetSpeedCommand{NextSpeed(context.playback->speed, -1)});
    case keys::kRightBracket:
      return sink.Post(SetSpeedCommand{NextSpeed(context.playback->speed, 1)});
    case keys::kG:
      return sink.Post(AskFrameCommand{});
    case '0':
      return sink.Post(LookThroughCommand{!context.look_through});
    case keys::kP:
      return sink.Post(ShowPaletteCommand{true});
    case keys::kL:
      if (shortcut.control) return sink.Post(SetThemeCommand{!context.light});
      return sink.Post(SetLoopCommand{!context.playback->loop});
    case keys::kN:
      return sink.Post(FollowNewestCommand{!context.playback->follow});
    case keys::kI:
      return sink.Post(SetRangeCommand{context.playback->frame, context.playback->range_end});
    case keys::kO:
      return sink.Post(SetRangeCommand{context.playback->range_begin, context.playback->frame});
    case keys::kB:
      return sink.Post(BookmarkCommand{context.playback->frame, ""});
    case keys::kV:
      return sink.Post(ShowRunCommand{context.run_shown == RunShown::kOther ? RunShown::kFirst
                                                                            : RunShown::kOther});
    case keys::kF:
      return sink.Post(FocusSelectionCommand{});
    case keys::kR:
      return sink.Post(ResetViewCommand{});
    case keys::kEscape:
      if (help_shown) return sink.Post(ShowHelpCommand{false});
      return sink.Post(SelectObjectCommand{});
    case keys::kEqual:
      return sink.Post(SetUiScaleCommand{context.ui_scale * 1.1});
    case keys::kMinus:
      return sink.Post(SetUiScaleCommand{context.ui_scale / 1.1});
    case keys::kF5:
      return sink.Post(PresentCommand{});
    case keys::kF12:
      return sink.Post(ScreenshotCommand{});
    case keys::kF1:
    case keys::kSlash:
      return sink.Post(ShowHelpCommand{!help_shown});
    case keys::kQ:
      return sink.Post(QuitCommand{});
    default:
      for (const AxisView& view : AxisViews()) {
        if (shortcut.key == view.key)
          sink.Post(ViewDirectionCommand{view.azimuth_rad, view.elevation_rad});
      }
  }
}

}  // namespace

std::span<const Shortcut> Shortcuts() { return kShortcuts; }
std::span<const double> PlaybackSpeeds() { return kSpeeds; }

std::span<const AxisView> AxisViews() {
  static constexpr AxisView kViews[] = {{'1', "the front (-y)", -90 * kRadPerDeg, 0},
                                        {'2', "the back (+y)", 90 * kRadPerDeg, 0},
                                        {'3', "the left (-x)", 180 * kRadPerDeg, 0},
                                        {'4', "the right (+x)", 0, 0},
                                        {'5', "above", -90 * kRadPerDeg, 89.9 * kRadPerDeg},
                                        {'6', "an angle", -55 * kRadPerDeg, 35 * kRadPerDeg}};
  return kViews;
}

int KeyByName(std::string_view name) {
  static const std::map<std::string_view, int> kNames = {
      {"space", keys::kSpace},   {"left", keys::kLeft},     {"right", keys::kRight},
      {"enter", keys::kEnter},   {"up", keys::kUp},         {"down", keys::kDown},
      {"delete", keys::kDelete}, {"home", keys::kHome},     {"end", keys::kEnd},
      {"escape", keys::kEscape}, {"f1", keys::kF1},         {"f5", keys::kF5},
      {"f12", keys::kF12},       {"[", keys::kLeftBracket}, {"]", keys::kRightBracket},
      {"?", keys::kSlash},       {"/", keys::kSlash},       {",", keys::kComma},
      {".", keys::kPeriod},      {"=", keys::kEqual},       {"-", keys::kMinus}};
  if (const auto found = kNames.find(name); found != kNames.end()) return found->second;
  if (name.size() == 1 && std::isalnum(static_cast<unsigned char>(name[0]))) {
    return std::toupper(static_cast<unsigned char>(name[0]));
  }
  return -1;
}

void PostShortcuts(const FrameContext& context, bool help_shown, CommandSink& sink) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId)) return;
  bool playback = true;
  for (const Shortcut& shortcut : kShortcuts) {
    // Aliases belong to the row before them.
    if (*shortcut.group != '\0') playback = std::string_view(shortcut.group) == "Playback";
    const bool inspect_only =
        playback || shortcut.key == '0' || (shortcut.key == keys::kEscape && !help_shown);
    if (inspect_only && context.workspace != WorkspaceId::kInspect) continue;
    if (shortcut.shift != io.KeyShift || shortcut.control != io.KeyCtrl || io.KeyAlt) continue;
    const bool repeats = shortcut.key == keys::kLeft || shortcut.key == keys::kRight;
    if (ImGui::IsKeyPressed(shortcut.key, repeats))
      PostShortcut(shortcut, context, help_shown, sink);
  }
}

}  // namespace plumbline
