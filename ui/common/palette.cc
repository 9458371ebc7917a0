// SPDX-License-Identifier: Apache-2.0
#include "ui/common/palette.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "ui/framework/actions.h"
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

std::string HintOf(const FrameContext& context, const PaletteState& state) {
  if (!state.within.empty()) return state.within + " ...";
  const bool frames = context.workspace == WorkspaceId::kInspect;
  return frames ? "What to do? A number goes to that frame" : "What to do?";
}

/// 0: it is the whole text; 1: the text begins with it; 2: its words are somewhere in the text.
int RankOf(const std::string& text, const std::string& query) {
  const std::string whole = Lower(text), typed = Lower(query);
  return whole == typed ? 0 : whole.starts_with(typed) ? 1 : 2;
}

/// The first of `all` that fit, after what comes at once; what was typed in full is not hidden
/// behind what only contains it.
std::vector<PaletteEntry> Fitting(std::vector<PaletteEntry> all, std::vector<PaletteEntry> at_once,
                                  const std::string& query) {
  std::erase_if(all, [&](const PaletteEntry& entry) { return !Fits(entry.text, query); });
  std::stable_sort(all.begin(), all.end(), [&](const PaletteEntry& a, const PaletteEntry& b) {
    return RankOf(a.text, query) < RankOf(b.text, query);
  });
  for (PaletteEntry& entry : all) {
    if (at_once.size() >= kMostEntries) break;
    at_once.push_back(std::move(entry));
  }
  return at_once;
}

}  // namespace

std::vector<PaletteEntry> EntriesOf(std::span<const ActionGroup> groups,
                                    const FrameContext& context) {
  std::vector<PaletteEntry> entries;
  for (const ActionGroup& group : groups) {
    for (const Action& action : group.actions) {
      if (!action.run || action.text.empty()) continue;
      if (action.is_offered && !action.is_offered(context)) continue;
      const bool on = action.is_on && action.is_on(context);
      entries.push_back({on ? action.text_when_on : action.text,
                         action.keys.empty() ? "" : NameOf(action.keys.front()),
                         [run = action.run, &context](CommandSink& sink) { run(context, sink); }});
    }
  }
  return entries;
}

void AddRecentEntries(const FrameContext& context, std::vector<PaletteEntry>& entries) {
  for (const std::string& path : context.recent)
    entries.push_back(
        EntryFor("Open " + (path == kDemoPath ? "the built-in demo" : path), OpenCommand{path}));
}

void DrawPalette(const FrameContext& context, PaletteState& state, std::vector<PaletteEntry> all,
                 const std::function<std::vector<PaletteEntry>(const std::string& query)>& at_once,
                 CommandSink& sink) {
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
      ImGui::InputTextWithHint("##palette", HintOf(context, state).c_str(), state.query,
                               sizeof(state.query), ImGuiInputTextFlags_EnterReturnsTrue);
  LogItem(context, "palette.query");
  if (before != state.query) state.chosen = 0;
  const std::vector<PaletteEntry> entries =
      state.within.empty() ? Fitting(std::move(all), at_once(state.query), state.query)
                           : Fitting(std::move(all), {}, state.within + " " + state.query);
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
