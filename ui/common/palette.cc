// SPDX-License-Identifier: Apache-2.0
#include "ui/common/palette.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "ui/framework/shortcuts.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr std::size_t kMostEntries = 14;

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool Fits(const std::string& text, const std::string& query) {
  std::istringstream words(Lower(query));
  const std::string whole = Lower(text);
  for (std::string word; words >> word;) {
    if (whole.find(word) == std::string::npos) return false;
  }
  return true;
}

template <typename C>
PaletteEntry Entry(std::string text, std::string keys, C command) {
  return {std::move(text), std::move(keys), [command](CommandSink& sink) { sink.Post(command); }};
}

void AddActions(const FrameContext& context, std::vector<PaletteEntry>& all) {
  const PlaybackView& playback = *context.playback;
  all.push_back(Entry("Play or pause", "Space", TogglePlayCommand{}));
  all.push_back(Entry("First frame", "Home", SeekCommand{0}));
  all.push_back(Entry("Newest mapped frame", "End", SeekCommand{playback.newest_mapped_frame}));
  all.push_back(Entry("One frame on", "Right", StepCommand{1}));
  all.push_back(Entry("One frame back", "Left", StepCommand{-1}));
  all.push_back(Entry("Ten frames on", "Shift + Right", StepCommand{10}));
  all.push_back(Entry("Ten frames back", "Shift + Left", StepCommand{-10}));
  all.push_back(Entry("Go to a frame by number", "G", AskFrameCommand{}));
  all.push_back(Entry(playback.loop ? "Do not loop" : "Loop", "L", SetLoopCommand{!playback.loop}));
  if (!playback.recorded) {
    all.push_back(Entry(playback.follow ? "Stop mapping" : "Map on and follow the newest frame",
                        "N", FollowNewestCommand{!playback.follow}));
    all.push_back(Entry("Change options of this run: what if?", "", AskOptionsCommand{}));
    if (playback.mapping) all.push_back(Entry("Pause the mapper", "", PauseCommand{}));
  }
  all.push_back(Entry("Play only after this frame", "I",
                      SetRangeCommand{playback.frame, playback.range_end}));
  all.push_back(Entry("Play only before this frame", "O",
                      SetRangeCommand{playback.range_begin, playback.frame}));
  all.push_back(Entry("Play everything: no sub-range", "", SetRangeCommand{}));
  all.push_back(Entry("Bookmark this frame", "B", BookmarkCommand{playback.frame, ""}));
  all.push_back(Entry("Fork the run from here: what if?", "", AskForkCommand{}));
  if (context.other != nullptr) {
    all.push_back(Entry("Two runs: show the first", "V", ShowRunCommand{RunShown::kFirst}));
    all.push_back(Entry("Two runs: show the other", "V", ShowRunCommand{RunShown::kOther}));
    all.push_back(Entry("Two runs: blink", "", ShowRunCommand{RunShown::kBlink}));
    all.push_back(Entry("Two runs: side by side", "", ShowRunCommand{RunShown::kBeside}));
    all.push_back(Entry("Two runs: close the other", "", CompareRunCommand{}));
  }
  for (const double speed : PlaybackSpeeds())
    all.push_back(Entry(speed > 0 ? fmt::format("Speed: {:g} times", speed)
                                  : std::string("Speed: as fast as it goes"),
                        "[ ]", SetSpeedCommand{speed}));
  all.push_back(Entry("Frame the selected object in the map", "F", FocusSelectionCommand{}));
  all.push_back(Entry("Reset the views", "R", ResetViewCommand{}));
  all.push_back(Entry("Clear the selection", "Esc", SelectObjectCommand{}));
  all.push_back(Entry(context.follow ? "Map: do not follow the camera" : "Map: follow the camera",
                      "", FollowCommand{!context.follow}));
  all.push_back(
      Entry(context.look_through ? "Map: leave the camera" : "Map: look through the camera", "0",
            LookThroughCommand{!context.look_through}));
  for (const AxisView& view : AxisViews())
    all.push_back(Entry(fmt::format("Map: from {}", view.name), std::string(1, view.key),
                        ViewDirectionCommand{view.azimuth_rad, view.elevation_rad}));
  all.push_back(Entry(context.light ? "Dark theme" : "Light theme", "Ctrl + L",
                      SetThemeCommand{!context.light}));
  all.push_back(Entry("Larger text", "Ctrl + =", SetUiScaleCommand{context.ui_scale * 1.1}));
  all.push_back(Entry("Smaller text", "Ctrl + -", SetUiScaleCommand{context.ui_scale / 1.1}));
  for (int count = 1; count <= 5; ++count)
    all.push_back(Entry(fmt::format("Image views: {}", count), "", ImageViewsCommand{count}));
  all.push_back(Entry("Save a picture of the window", "F12", ScreenshotCommand{}));
  for (const auto& [name, rect] : context.widgets->rects()) {
    if (name.starts_with("panel."))
      all.push_back(Entry("Save a picture of the panel " + name.substr(6), "right click",
                          ScreenshotCommand{"", name}));
  }
  all.push_back(
      Entry("Demo mode: full screen with captions, until any key", "F5", PresentCommand{}));
  all.push_back(Entry("Keys and mouse", "F1", ShowHelpCommand{true}));
  all.push_back(Entry("Quit", "Ctrl + Q", QuitCommand{}));
}

void AddThings(const FrameContext& context, std::vector<PaletteEntry>& all) {
  if (context.snapshot != nullptr) {
    for (const ObjectReport& object : context.snapshot->report.objects) {
      const ModelView* model = context.Model(object.label);
      all.push_back(Entry(
          fmt::format("Select object #{} {} ({})", object.id.value,
                      model != nullptr ? model->name : object.category, StateName(object.state)),
          "", SelectObjectCommand{object.id}));
    }
  }
  for (const Bookmark& bookmark : context.bookmarks)
    all.push_back(Entry(fmt::format("Bookmark {} {}", bookmark.frame, bookmark.note), "",
                        SeekCommand{bookmark.frame}));
  for (const std::string& path : context.recent) {
    if (path.ends_with(".plb") && !context.playback->recording.empty())
      all.push_back(Entry("Compare with " + path, "", CompareRunCommand{path}));
  }
  for (const std::string& path : context.recent)
    all.push_back(
        Entry("Open " + (path == kDemoPath ? "the built-in demo" : path), "", OpenCommand{path}));
}

}  // namespace

std::vector<PaletteEntry> PaletteEntries(const FrameContext& context, const std::string& query) {
  std::vector<PaletteEntry> all, fitting;
  const bool number =
      !query.empty() && query.size() < 8 &&
      std::all_of(query.begin(), query.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  if (number && context.sequence != nullptr) {
    const int frame = std::min(std::stoi(query), context.sequence->num_frames - 1);
    fitting.push_back(Entry(fmt::format("Go to frame {}", frame), "", SeekCommand{frame}));
  }
  AddActions(context, all);
  AddThings(context, all);
  for (PaletteEntry& entry : all) {
    if (Fits(entry.text, query)) fitting.push_back(std::move(entry));
  }
  if (fitting.size() > kMostEntries) fitting.resize(kMostEntries);
  return fitting;
}

void DrawPalette(const FrameContext& context, PaletteState& state, CommandSink& sink) {
  if (!state.open) return;
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float width = std::min(context.Scaled(560), 0.9f * display.x);
  ImGui::SetNextWindowPos({0.5f * (display.x - width), 0.12f * display.y});
  ImGui::SetNextWindowSize({width, 0});
  ImGui::SetNextWindowFocus();
  ImGui::PushStyleColor(ImGuiCol_WindowBg, colors::kSheet);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowRounding, context.Scaled(8));
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(12), context.Scaled(12)});
  ImGui::Begin(
      "palette", nullptr,
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  ImGui::SetNextItemWidth(-1);
  if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
  const std::string before = state.query;
  const bool entered =
      ImGui::InputTextWithHint("##palette", "What to do? A number goes to that frame", state.query,
                               sizeof(state.query), ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, "palette.query");
  if (before != state.query) state.chosen = 0;
  const std::vector<PaletteEntry> entries = PaletteEntries(context, state.query);
  const auto last = static_cast<int>(entries.size()) - 1;
  if (ImGui::IsKeyPressed(keys::kDown)) ++state.chosen;
  if (ImGui::IsKeyPressed(keys::kUp)) --state.chosen;
  state.chosen = std::clamp(state.chosen, 0, std::max(0, last));
  int run = entered && last >= 0 ? state.chosen : -1;
  ImGui::Dummy({0, context.Scaled(4)});
  if (entries.empty()) DimText("Nothing fits.");
  for (int i = 0; i <= last; ++i) {
    const PaletteEntry& entry = entries[static_cast<std::size_t>(i)];
    if (ImGui::Selectable(fmt::format("{}##{}", entry.text, i).c_str(), i == state.chosen)) run = i;
    LogItem(context, fmt::format("palette.entry.{}", i));
    if (entry.keys.empty()) continue;
    ImGui::SameLine();
    AlignRight(ImGui::CalcTextSize(entry.keys.c_str()).x);
    DimText("%s", entry.keys.c_str());
  }
  if (run >= 0) {
    entries[static_cast<std::size_t>(run)].run(sink);
    state = {};
  }
  if (ImGui::IsKeyPressed(keys::kEscape, false)) state = {};
  ImGui::End();
  ImGui::PopStyleVar(2);
  ImGui::PopStyleColor();
}

}  // namespace plumbline
