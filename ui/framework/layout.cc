// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/layout.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kGap = 6, kMargin = 8;
constexpr double kTopBar = 44, kLeastTimeline = 92, kStatusBar = 28;

/// Splits along x (or y) at `ratio`, leaving the gap between.
std::pair<LayoutRect, LayoutRect> Split(const LayoutRect& rect, bool along_x, double ratio,
                                        float gap) {
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
  const LayoutRect gap{{left.high.x, std::min(left.low.y, right.low.y)},
                       {right.low.x, std::max(left.high.y, right.high.y)}};
  Handle(context, name, true, gap, left.low.x, right.high.x - left.low.x, ratio);
}

void HandleY(const FrameContext& context, const char* name, const LayoutRect& above,
             const LayoutRect& below, double& ratio) {
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

void DrawTitle(const FrameContext& context, Panel& panel, std::span<Panel* const> tabs,
               std::size_t* active, CommandSink& sink, const std::function<void()>& menu) {
  for (std::size_t i = 0; i < tabs.size(); ++i) {
    const bool is_active = tabs[i] == &panel;
    if (i > 0) ImGui::SameLine(0, context.Scaled(14));
    ImGui::PushFont(context.fonts.strong);
    ImGui::PushStyleColor(ImGuiCol_Text, is_active ? colors::kText : colors::kFaint);
    ImGui::TextUnformatted(tabs[i]->info().title);
    ImGui::PopStyleColor();
    ImGui::PopFont();
    LogItem(context, std::string(tabs[i]->id()) + ".title");
    if (tabs.size() > 1 && is_active) {
      const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
      ImGui::GetWindowDrawList()->AddRectFilled({low.x, high.y + context.Scaled(2)},
                                                {high.x, high.y + context.Scaled(4)},
                                                colors::kAccent);
    }
    const bool clicked = ImGui::IsItemClicked();
    const char* more = menu ? "\nA click chooses what is shown here; a right click saves it as PNG."
                            : "\nA right click saves it as PNG.";
    Tooltip(context, tabs[i]->info().help + std::string(is_active ? more : ""));
    if (is_active && ImGui::IsItemClicked(ImGuiMouseButton_Right))
      sink.Post(ScreenshotCommand{"", std::string("panel.") + panel.id()});
    if (menu && !context.bare) {
      DrawMenuMark(context);
      if (clicked) ImGui::OpenPopup("title menu");
      if (ImGui::BeginPopup("title menu")) {
        menu();
        ImGui::EndPopup();
      }
    }
    if (active != nullptr && clicked) *active = i;
  }
  ImGui::SameLine(0, context.Scaled(12));
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {context.Scaled(3), context.Scaled(4)});
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() - context.Scaled(2));
  if (!context.bare) panel.DrawHeader(context, sink);
  ImGui::PopStyleVar();
  const float content_y = context.Scaled(6) + ImGui::GetTextLineHeight() + context.Scaled(7);
  ImGui::SetCursorPos({context.Scaled(8), content_y});
}

}  // namespace

nlohmann::json RatiosToJson(const LayoutRatios& ratios) {
  nlohmann::json json;
  VisitFields(const_cast<LayoutRatios&>(ratios),
              [&](double& ratio, const char* name) { json[name] = ratio; });
  return json;
}

void RatiosFromJson(const nlohmann::json& json, LayoutRatios& ratios) {
  VisitFields(ratios, [&](double& ratio, const char* name) {
    const auto found = json.find(name);
    if (found != json.end() && found->is_number())
      ratio = std::clamp(found->get<double>(), 0.05, 0.85);
  });
}

WindowLayout ComputeWindowLayout(ImVec2 size, double ui_scale) {
  const auto scaled = [&](double v) { return static_cast<float>(std::round(v * ui_scale)); };
  WindowLayout layout;
  layout.top_bar = {{0, 0}, {size.x, scaled(kTopBar)}};
  layout.status_bar = {{0, size.y - scaled(kStatusBar)}, size};
  layout.room = {{0, layout.top_bar.high.y}, {size.x, layout.status_bar.low.y}};
  return layout;
}

InspectLayout ComputeInspectLayout(ImVec2 size, double ui_scale, const LayoutRatios& ratios) {
  const auto scaled = [&](double v) { return static_cast<float>(std::round(v * ui_scale)); };
  const float gap = scaled(kGap), margin = scaled(kMargin);
  InspectLayout layout;
  const WindowLayout window = ComputeWindowLayout(size, ui_scale);
  layout.top_bar = window.top_bar;
  layout.status_bar = window.status_bar;
  const float timeline =
      std::max(scaled(kLeastTimeline), std::floor(static_cast<float>(ratios.timeline) * size.y));
  layout.timeline = {{margin, layout.status_bar.low.y - timeline},
                     {size.x - margin, layout.status_bar.low.y}};
  const LayoutRect main{{margin, layout.top_bar.high.y},
                        {size.x - margin, layout.timeline.low.y - gap}};
  const auto [left, right] = Split(main, true, ratios.columns, gap);
  LayoutRect small, top, bottom, below;
  std::tie(layout.image, small) = Split(left, false, ratios.image, gap);
  std::tie(top, bottom) = Split(small, false, ratios.small_rows, gap);
  std::tie(layout.edges, layout.depth) = Split(top, true, ratios.small_columns, gap);
  std::tie(layout.masks, layout.particles) = Split(bottom, true, ratios.small_columns, gap);
  std::tie(layout.scene, below) = Split(right, false, ratios.scene, gap);
  LayoutRect row;
  std::tie(layout.objects, row) = Split(below, false, ratios.objects, gap);
  std::tie(layout.details, layout.timings) = Split(row, true, ratios.details, gap);
  return layout;
}

void DragSplitters(const FrameContext& context, const InspectLayout& layout, LayoutRatios& ratios) {
  const LayoutRect left{layout.image.low, {layout.image.high.x, layout.masks.high.y}};
  const LayoutRect right{layout.scene.low, {layout.scene.high.x, layout.timings.high.y}};
  const LayoutRect small{layout.edges.low, layout.particles.high};
  const LayoutRect top{layout.edges.low, layout.depth.high};
  const LayoutRect bottom{layout.masks.low, layout.particles.high};
  const LayoutRect small_left{layout.edges.low, layout.masks.high};
  const LayoutRect small_right{layout.depth.low, layout.particles.high};
  const LayoutRect below{layout.objects.low, layout.timings.high};
  const LayoutRect row{layout.details.low, layout.timings.high};
  double above = -1;
  HandleY(
      context, "split.timeline",
      {layout.top_bar.low, {layout.top_bar.high.x, layout.timeline.low.y - context.Scaled(kGap)}},
      {layout.timeline.low, layout.status_bar.high}, above);
  if (above >= 0) ratios.timeline = std::min(1 - above, 0.6);
  HandleX(context, "split.columns", left, right, ratios.columns);
  HandleY(context, "split.image", layout.image, small, ratios.image);
  HandleY(context, "split.small_rows", top, bottom, ratios.small_rows);
  HandleX(context, "split.small_columns", small_left, small_right, ratios.small_columns);
  HandleY(context, "split.scene", layout.scene, below, ratios.scene);
  HandleY(context, "split.objects", layout.objects, row, ratios.objects);
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
