// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/layout.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kGap = 6, kMargin = 8;
constexpr double kCompactBelow = 1200;
constexpr double kTopBar = 44, kLeastTimeline = 92, kStatusBar = 28;

/// Splits along x (or y) at `ratio`, leaving the gap between. Where one is not wanted, the other
/// has it all.
std::pair<LayoutRect, LayoutRect> Split(const LayoutRect& rect, bool along_x, double ratio,
                                        float gap, bool wants_first = true,
                                        bool wants_second = true) {
  if (!wants_first) return {{rect.low, rect.low}, rect};
  if (!wants_second) return {rect, {rect.high, rect.high}};
  LayoutRect first = rect, second = rect;
  if (along_x) {
    first.high.x = std::floor(rect.low.x + static_cast<float>(ratio) * (rect.width() - gap));
    second.low.x = first.high.x + gap;
  } else {
    first.high.y = std::floor(rect.low.y + static_cast<float>(ratio) * (rect.height() - gap));
    second.low.y = first.high.y + gap;
  }
  return {first, second};
}

/// A handle in the gap between `before` and `after`; `whole` is what the ratio divides.
void Handle(const FrameContext& context, const char* name, bool along_x, const LayoutRect& gap,
            float whole_low, float whole_size, double& ratio) {
  ImGui::SetCursorScreenPos(gap.low);
  ImGui::InvisibleButton(name, {std::max(gap.width(), 1.0f), std::max(gap.height(), 1.0f)});
  LogItem(context, name);
  const bool active = ImGui::IsItemActive();
  if (active) {
    const float mouse = along_x ? ImGui::GetIO().MousePos.x : ImGui::GetIO().MousePos.y;
    ratio = std::clamp(static_cast<double>((mouse - whole_low) / whole_size), 0.15, 0.85);
  }
  if (active || ImGui::IsItemHovered()) {
    ImGui::SetMouseCursor(along_x ? ImGuiMouseCursor_ResizeEW : ImGuiMouseCursor_ResizeNS);
    ImVec2 low = gap.low, high = gap.high;
    const float inset = context.Scaled(2);
    along_x ? (low.x += inset, high.x -= inset) : (low.y += inset, high.y -= inset);
    ImGui::GetWindowDrawList()->AddRectFilled(low, high, colors::kAccent, inset);
  }
}

void HandleX(const FrameContext& context, const char* name, const LayoutRect& left,
             const LayoutRect& right, double& ratio) {
  if (left.width() < 1 || right.width() < 1) return;
  const LayoutRect gap{{left.high.x, std::min(left.low.y, right.low.y)},
                       {right.low.x, std::max(left.high.y, right.high.y)}};
  Handle(context, name, true, gap, left.low.x, right.high.x - left.low.x, ratio);
}

void HandleY(const FrameContext& context, const char* name, const LayoutRect& above,
             const LayoutRect& below, double& ratio) {
  if (above.height() < 1 || below.height() < 1) return;
  const LayoutRect gap{{std::min(above.low.x, below.low.x), above.high.y},
                       {std::max(above.high.x, below.high.x), below.low.y}};
  Handle(context, name, false, gap, above.low.y, below.high.y - above.low.y, ratio);
}

/// A small triangle behind a title that opens a menu.
void DrawMenuMark(const FrameContext& context) {
  const ImVec2 high = ImGui::GetItemRectMax(), low = ImGui::GetItemRectMin();
  const float x = high.x + context.Scaled(5), y = 0.5f * (low.y + high.y), r = context.Scaled(3);
  ImGui::GetWindowDrawList()->AddTriangleFilled({x, y - 0.6f * r}, {x + 2 * r, y - 0.6f * r},
                                                {x + r, y + r}, colors::kFaint);
}

/// How many tabs fit, with room for the mark that opens the others and for a menu of controls.
std::size_t TabsThatFit(const FrameContext& context, std::span<Panel* const> tabs) {
  const float gap = context.Scaled(14);
  // Beside what opens the controls.
  const float room = ImGui::GetContentRegionAvail().x - ToggleWidth(context, "Show") - gap;
  ImGui::PushFont(context.fonts.strong);
  float width = 0, with_mark = 0;
  std::size_t fit = 0;
  for (std::size_t i = 0; i < tabs.size(); ++i) {
    width += ImGui::CalcTextSize(tabs[i]->info().title).x + (i > 0 ? gap : 0.0f);
    with_mark = width + gap + ImGui::CalcTextSize("\u00bb").x;
    if (with_mark <= room || (i + 1 == tabs.size() && width <= room)) fit = i + 1;
  }
  ImGui::PopFont();
  return std::max<std::size_t>(fit, 1);
}

/// What a double click on the title of a panel does. The first click may have opened its menu.
void MaximizeByDoubleClick(const FrameContext& context, const Panel& panel, CommandSink& sink) {
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  constexpr ImGuiHoveredFlags kThroughMenu = ImGuiHoveredFlags_AllowWhenBlockedByPopup;
  // The fourth of four quick clicks is the second of two.
  const int clicks = ImGui::GetMouseClickedCount(ImGuiMouseButton_Left);
  if (context.bare || clicks == 0 || clicks % 2 != 0 || !ImGui::IsMouseHoveringRect(low, high) ||
      !ImGui::IsWindowHovered(kThroughMenu))
    return;
  sink.Post(MaximizePanelCommand{panel.id()});
}

void DrawTab(const FrameContext& context, const Panel& tab, bool is_active, bool one_of_many,
             CommandSink& sink) {
  ImGui::PushFont(context.fonts.strong);
  ImGui::PushStyleColor(ImGuiCol_Text, is_active ? colors::kText : colors::kFaint);
  ImGui::TextUnformatted(tab.info().title);
  ImGui::PopStyleColor();
  ImGui::PopFont();
  LogItem(context, std::string(tab.id()) + ".title");
  MaximizeByDoubleClick(context, tab, sink);
  if (!one_of_many || !is_active) return;
  const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
  ImGui::GetWindowDrawList()->AddRectFilled({low.x, high.y + context.Scaled(2)},
                                            {high.x, high.y + context.Scaled(4)}, colors::kAccent);
}

/// A mark behind the tabs that fit, which opens a menu of the others.
void DrawOtherTabs(const FrameContext& context, const Panel& panel, std::span<Panel* const> tabs,
                   std::size_t first, std::size_t& active) {
  ImGui::SameLine(0, context.Scaled(14));
  ImGui::TextUnformatted("\u00bb");
  LogItem(context, std::string(tabs.front()->id()) + ".more");
  Tooltip(context, "The other panels of this place.");
  if (ImGui::IsItemClicked()) ImGui::OpenPopup("other tabs");
  if (!ImGui::BeginPopup("other tabs")) return;
  for (std::size_t i = first; i < tabs.size(); ++i) {
    if (tabs[i] == &panel) continue;
    if (ImGui::MenuItem(tabs[i]->info().title)) active = i;
    LogItem(context, std::string("tab.") + tabs[i]->id());
  }
  ImGui::EndPopup();
}

/// The controls of a panel behind its title, or a menu of them where they do not fit.
void DrawControls(const FrameContext& context, Panel& panel, CommandSink& sink) {
  const float start = ImGui::GetCursorScreenPos().x, room = ImGui::GetContentRegionAvail().x;
  // What did not fit in the last frame shows how much room they take.
  ImGuiStorage& storage = *ImGui::GetStateStorage();
  const ImGuiID key = ImGui::GetID("room of the controls");
  if (storage.GetFloat(key) <= room) {
    panel.DrawHeader(context, sink);
    const float right = ImGui::GetItemRectMax().x;
    return storage.SetFloat(key, right > start + room + 1 ? right - start : 0.0f);
  }
  AlignRight(ToggleWidth(context, "Show"));
  bool open = false;
  if (Toggle(context, std::string(panel.id()) + ".controls", "Show", open,
             "What this panel shows."))
    ImGui::OpenPopup("controls");
  if (!ImGui::BeginPopup("controls")) return;
  panel.DrawHeader(context, sink);
  ImGui::EndPopup();
}

void DrawTitle(const FrameContext& context, Panel& panel, std::span<Panel* const> all_tabs,
               std::size_t* active, CommandSink& sink, const std::function<void()>& menu) {
  std::vector<Panel*> tabs(all_tabs.begin(), all_tabs.end());
  const std::size_t fit = TabsThatFit(context, tabs);
  const auto front = std::find(tabs.begin(), tabs.end(), &panel);
  if (front - tabs.begin() >= static_cast<std::ptrdiff_t>(fit))
    std::rotate(tabs.begin() + static_cast<std::ptrdiff_t>(fit) - 1, front, front + 1);
  std::size_t chosen = tabs.size();
  for (std::size_t i = 0; i < fit; ++i) {
    const bool is_active = tabs[i] == &panel;
    if (i > 0) ImGui::SameLine(0, context.Scaled(14));
    DrawTab(context, *tabs[i], is_active, tabs.size() > 1, sink);
    const bool clicked = ImGui::IsItemClicked();
    std::string help = tabs[i]->info().help;
    if (is_active)
      help +=
          std::string(menu ? "\nA click chooses what is shown here; a" : "\nA") +
          " double click fills the window with it, and back (M); a right click saves it as PNG.";
    Tooltip(context, help);
    if (is_active && ImGui::IsItemClicked(ImGuiMouseButton_Right))
      sink.Post(ScreenshotCommand{"", std::string("panel.") + panel.id()});
    if (menu && !context.bare) {
      DrawMenuMark(context);
      if (clicked && context.maximized.empty()) ImGui::OpenPopup("title menu");
      // Below the title, which may be clicked a second time.
      ImGui::SetNextWindowPos(
          {ImGui::GetItemRectMin().x, ImGui::GetItemRectMax().y + context.Scaled(4)});
      if (ImGui::BeginPopup("title menu")) {
        if (!context.maximized.empty()) ImGui::CloseCurrentPopup();
        menu();
        ImGui::EndPopup();
      }
    }
    if (clicked) chosen = i;
  }
  if (fit < tabs.size()) DrawOtherTabs(context, panel, tabs, fit, chosen);
  if (active != nullptr && chosen < tabs.size())
    *active = static_cast<std::size_t>(std::find(all_tabs.begin(), all_tabs.end(), tabs[chosen]) -
                                       all_tabs.begin());
  if (!context.maximized.empty() && context.maximized == panel.id()) {
    ImGui::SameLine(0, context.Scaled(14));
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - context.Scaled(2));
    bool on = true;
    if (Toggle(context, "panel.restore", "Back", on, "Brings the other panels back (M)."))
      sink.Post(MaximizePanelCommand{});
  }
  ImGui::SameLine(0, context.Scaled(12));
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {context.Scaled(3), context.Scaled(4)});
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() - context.Scaled(2));
  if (!context.bare) DrawControls(context, panel, sink);
  ImGui::PopStyleVar();
  const float content_y = context.Scaled(6) + ImGui::GetTextLineHeight() + context.Scaled(7);
  ImGui::SetCursorPos({context.Scaled(8), content_y});
}

}  // namespace

WindowLayout ComputeWindowLayout(ImVec2 size, double ui_scale) {
  const auto scaled = [&](double v) { return static_cast<float>(std::round(v * ui_scale)); };
  WindowLayout layout;
  layout.top_bar = {{0, 0}, {size.x, scaled(kTopBar)}};
  layout.status_bar = {{0, size.y - scaled(kStatusBar)}, size};
  layout.room = {{0, layout.top_bar.high.y}, {size.x, layout.status_bar.low.y}};
  return layout;
}

bool IsCompact(ImVec2 size, double ui_scale) { return size.x < kCompactBelow * ui_scale; }

InspectLayout ComputeInspectLayout(ImVec2 size, double ui_scale, const LayoutRatios& ratios,
                                   const InspectRegions& regions) {
  const auto scaled = [&](double v) { return static_cast<float>(std::round(v * ui_scale)); };
  const float gap = scaled(kGap), margin = scaled(kMargin);
  InspectLayout layout;
  const WindowLayout window = ComputeWindowLayout(size, ui_scale);
  layout.top_bar = window.top_bar;
  layout.status_bar = window.status_bar;
  const float timeline = regions.timeline
                             ? std::max(scaled(kLeastTimeline),
                                        std::floor(static_cast<float>(ratios.timeline) * size.y))
                             : 0.0f;
  layout.timeline = {{margin, layout.status_bar.low.y - timeline},
                     {size.x - margin, layout.status_bar.low.y}};
  layout.main = {{margin, layout.top_bar.high.y},
                 {size.x - margin, layout.timeline.low.y - (regions.timeline ? gap : 0.0f)}};
  const bool row = regions.about_object || regions.timings, below = regions.about_map || row;
  std::tie(layout.left, layout.right) =
      Split(layout.main, true, ratios.columns, gap, regions.images, regions.map || below);
  LayoutRect small, top, bottom;
  std::tie(layout.image, small) = Split(layout.left, false, ratios.image, gap);
  std::tie(top, bottom) = Split(small, false, ratios.small_rows, gap);
  std::tie(layout.edges, layout.depth) = Split(top, true, ratios.small_columns, gap);
  std::tie(layout.masks, layout.particles) = Split(bottom, true, ratios.small_columns, gap);
  std::tie(layout.scene, layout.below) =
      Split(layout.right, false, ratios.scene, gap, regions.map, below);
  std::tie(layout.objects, layout.row) =
      Split(layout.below, false, ratios.objects, gap, regions.about_map, row);
  std::tie(layout.details, layout.timings) =
      Split(layout.row, true, ratios.details, gap, regions.about_object, regions.timings);
  return layout;
}

void DragSplitters(const FrameContext& context, const InspectLayout& layout, int image_views,
                   LayoutRatios& ratios) {
  const LayoutRect small{layout.edges.low, layout.particles.high};
  const LayoutRect top{layout.edges.low, layout.depth.high};
  const LayoutRect bottom{layout.masks.low, layout.particles.high};
  const LayoutRect small_left{layout.edges.low, layout.masks.high};
  const LayoutRect small_right{layout.depth.low, layout.particles.high};
  double above = -1;
  if (layout.timeline.height() > 1)
    HandleY(context, "split.timeline", layout.main, {layout.timeline.low, layout.status_bar.high},
            above);
  if (above >= 0) ratios.timeline = std::min(1 - above, 0.6);
  HandleX(context, "split.columns", layout.left, layout.right, ratios.columns);
  if (image_views > 1) HandleY(context, "split.image", layout.image, small, ratios.image);
  if (image_views > 4) HandleY(context, "split.small_rows", top, bottom, ratios.small_rows);
  if (image_views > 2)
    HandleX(context, "split.small_columns", small_left, small_right, ratios.small_columns);
  HandleY(context, "split.scene", layout.scene, layout.below, ratios.scene);
  HandleY(context, "split.objects", layout.objects, layout.row, ratios.objects);
  HandleX(context, "split.details", layout.details, layout.timings, ratios.details);
}

namespace {

void DrawFrame(const FrameContext& context, const LayoutRect& rect, Panel& panel,
               std::span<Panel* const> tabs, std::size_t* active, CommandSink& sink,
               const std::function<void()>& menu = {}) {
  const ImVec2 size(rect.width(), rect.height());
  if (size.x < 8 || size.y < 8) return;
  ImGui::SetCursorScreenPos(rect.low);
  ImGui::PushStyleColor(ImGuiCol_ChildBg, colors::kPanel);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(8), context.Scaled(6)});
  ImGui::BeginChild(panel.id(), size, true,
                    ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse |
                        ImGuiWindowFlags_AlwaysUseWindowPadding);
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
  // Smaller, and what ImGui draws would reach out of the panel.
  constexpr float kLeastSide = 48;
  if (size.x >= kLeastSide && size.y >= kLeastSide) {
    if (panel.info().has_title_row) DrawTitle(context, panel, tabs, active, sink, menu);
    panel.Draw(context, sink);
  }
  ImGui::EndChild();
  LogItem(context, std::string("panel.") + panel.id());
}

}  // namespace

void DrawPanel(const FrameContext& context, const LayoutRect& rect, Panel& panel, CommandSink& sink,
               const std::function<void()>& menu) {
  Panel* const only[] = {&panel};
  DrawFrame(context, rect, panel, only, nullptr, sink, menu);
}

void DrawTabbedPanels(const FrameContext& context, const LayoutRect& rect,
                      std::span<Panel* const> panels, std::size_t& active, CommandSink& sink) {
  active = std::min(active, panels.size() - 1);
  DrawFrame(context, rect, *panels[active], panels, &active, sink);
}

}  // namespace plumbline
