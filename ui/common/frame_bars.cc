// SPDX-License-Identifier: Apache-2.0
#include "ui/common/frame_bars.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

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

/// A workspace's name; the one that shows is underlined.
void DrawTab(const FrameContext& context, const LayoutRect& bar, const WorkspaceTab& tab,
             CommandSink& sink) {
  const bool shown = context.workspace == tab.id;
  const ImVec2 low = ImGui::GetCursorScreenPos();
  ImGui::PushStyleColor(ImGuiCol_Text, shown ? colors::kText : colors::kDimText);
  ImGui::TextUnformatted(tab.title);
  ImGui::PopStyleColor();
  LogItem(context, tab.widget);
  Tooltip(context, tab.help);
  if (ImGui::IsItemClicked()) sink.Post(SwitchWorkspaceCommand{tab.id});
  if (!shown) return;
  ImGui::GetWindowDrawList()->AddRectFilled(
      {low.x, bar.high.y - context.Scaled(5)},
      {low.x + ImGui::CalcTextSize(tab.title).x, bar.high.y - context.Scaled(3)}, colors::kAccent);
}

void DrawKeyRows(const FrameContext& context, std::span<const ActionGroup> groups) {
  for (const ActionGroup& group : groups) {
    bool headed = false;
    for (const Action& action : group.actions) {
      if (action.help.empty()) continue;
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      if (!std::exchange(headed, true)) {
        SmallText(context, colors::kAccent, "%s", group.title.c_str());
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
      }
      ImGui::TextUnformatted(action.help_keys.c_str());
      ImGui::TableNextColumn();
      ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + context.Scaled(380));
      DimText("%s", action.help.c_str());
      ImGui::PopTextWrapPos();
    }
  }
}

/// How many of the groups stand left of the mouse's `mouse_rows` and the rest, so that both columns
/// are about as high.
std::size_t GroupsOfLeftColumn(std::span<const ActionGroup> groups, std::size_t mouse_rows) {
  const auto rows = [](const ActionGroup& group) {
    const auto told = std::count_if(group.actions.begin(), group.actions.end(),
                                    [](const Action& action) { return !action.help.empty(); });
    return static_cast<std::size_t>(told > 0 ? told + 1 : 0);
  };
  std::size_t all = mouse_rows;
  for (const ActionGroup& group : groups) all += rows(group);
  std::size_t left = 0, high = 0;
  while (left < groups.size() && 2 * (high + rows(groups[left])) <= all + 4)
    high += rows(groups[left++]);
  return left;
}

}  // namespace

void DrawTopBar(const FrameContext& context, const LayoutRect& rect,
                std::span<const WorkspaceTab> tabs,
                const std::function<void(const LayoutRect&)>& middle, CommandSink& sink) {
  const float mid_y = 0.5f * (rect.low.y + rect.high.y);
  const float line = ImGui::GetTextLineHeight();
  DrawLogo({rect.low.x + context.Scaled(24), mid_y}, context.Scaled(10));
  ImGui::SetCursorScreenPos({rect.low.x + context.Scaled(42), mid_y - 0.5f * line});
  ImGui::PushFont(context.fonts.strong);
  ImGui::TextUnformatted("Plumbline");
  ImGui::PopFont();
  for (const WorkspaceTab& tab : tabs) {
    ImGui::SameLine(0, context.Scaled(&tab == &tabs.front() ? 24 : 16));
    DrawTab(context, rect, tab, sink);
  }
  ImGui::SameLine(0, context.Scaled(24));
  const float button = ImGui::GetFrameHeight() + context.Scaled(4);
  const float buttons = 2 * button + context.Scaled(26);
  middle({{ImGui::GetCursorScreenPos().x, rect.low.y}, {rect.high.x - buttons, rect.high.y}});
  ImGui::SetCursorScreenPos({rect.high.x - 2 * button - context.Scaled(14), mid_y - 0.5f * button});
  if (IconButton(context, "top.screenshot", Icon::kCamera, false,
                 "Save a picture of the window (F12)"))
    sink.Post(ScreenshotCommand{});
  ImGui::SameLine(0, context.Scaled(4));
  if (IconButton(context, "top.help", Icon::kHelp, false, "Keys and mouse (F1 or ?)"))
    sink.Post(ShowHelpCommand{true});
}

void DrawStatusBar(const FrameContext& context, const LayoutRect& rect, const StatusLine& status,
                   const std::string& note) {
  const float y = 0.5f * (rect.low.y + rect.high.y) - 0.5f * context.fonts.small->FontSize;
  const std::string right = fmt::format("window {:.1f} ms  \u00b7  3-D {:.0f} ms  \u00b7  {}",
                                        context.window_ms, context.scene_ms, context.renderer);
  const float right_width =
      context.fonts.small->CalcTextSizeA(context.fonts.small->FontSize, 1e6f, 0, right.c_str()).x;
  const float right_x = rect.high.x - right_width - context.Scaled(14);
  const bool both = rect.width() > context.Scaled(900);
  ImGui::PushClipRect(rect.low, {both ? right_x - context.Scaled(10) : rect.high.x, rect.high.y},
                      true);
  ImGui::SetCursorScreenPos({rect.low.x + context.Scaled(14), y});
  const std::string& text = note.empty() || status.failed ? status.text : note;
  SmallText(context, status.failed ? colors::kBad : colors::kDimText, "%s", text.c_str());
  Tooltip(context, text);
  ImGui::PopClipRect();
  if (!both) return;
  ImGui::SetCursorScreenPos({right_x, y});
  SmallText(context, colors::kFaint, "%s", right.c_str());
}

void DrawHelpSheet(const FrameContext& context, std::span<const ActionGroup> groups,
                   CommandSink& sink) {
  constexpr const char* kMouse[][2] = {{"Left drag", "Turn the map; move a zoomed image"},
                                       {"Right or middle drag", "Move the map"},
                                       {"Shift + left drag", "Move the map"},
                                       {"Wheel", "Zoom the map or the images"},
                                       {"Double click", "Turn about a point; show the whole image"},
                                       {"Click", "Select an object"},
                                       {"Click on an image's title", "Choose what it shows"},
                                       {"Double click on a title", "Fill the window, and back"},
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
  ImGui::SameLine(0, context.Scaled(24));
  if (Button(context, "help.close", "Close", "Esc closes it too."))
    sink.Post(ShowHelpCommand{false});
  constexpr auto kFlags = ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_NoHostExtendX;
  const std::size_t left = GroupsOfLeftColumn(groups, std::size(kMouse) + 1);
  if (ImGui::BeginTable("help.table", 2, kFlags)) {
    DrawKeyRows(context, groups.first(left));
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
    DrawKeyRows(context, groups.subspan(left));
    ImGui::EndTable();
  }
  ImGui::End();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar(2);
}

}  // namespace plumbline
