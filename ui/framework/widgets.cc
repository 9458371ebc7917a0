// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/widgets.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <limits>
#include <optional>

#include <imgui_internal.h>

namespace plumbline {
namespace {

void DrawIcon(Icon icon, ImVec2 c, float r, ImU32 color) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const auto triangle = [&](float x, float direction, float size) {
    const ImVec2 a(x - direction * size * 0.75f, c.y - size), b(x + direction * size * 0.85f, c.y),
        d(x - direction * size * 0.75f, c.y + size);
    // Anti-aliased filling wants one winding.
    direction > 0 ? draw.AddTriangleFilled(a, b, d, color) : draw.AddTriangleFilled(d, b, a, color);
  };
  const auto bar = [&](float x, float half_width, float half_height) {
    draw.AddRectFilled({x - half_width, c.y - half_height}, {x + half_width, c.y + half_height},
                       color, 1.0f);
  };
  switch (icon) {
    case Icon::kPlay:
      triangle(c.x, 1, r);
      break;
    case Icon::kPause:
      bar(c.x - 0.45f * r, 0.24f * r, r * 0.95f);
      bar(c.x + 0.45f * r, 0.24f * r, r * 0.95f);
      break;
    case Icon::kStepForward:
      bar(c.x - 0.75f * r, 0.14f * r, r * 0.85f);
      triangle(c.x + 0.3f * r, 1, 0.8f * r);
      break;
    case Icon::kStepBack:
      bar(c.x + 0.75f * r, 0.14f * r, r * 0.85f);
      triangle(c.x - 0.3f * r, -1, 0.8f * r);
      break;
    case Icon::kLast:
      triangle(c.x - 0.55f * r, 1, 0.75f * r);
      triangle(c.x + 0.35f * r, 1, 0.75f * r);
      bar(c.x + 1.1f * r, 0.14f * r, r * 0.8f);
      break;
    case Icon::kFirst:
      triangle(c.x + 0.55f * r, -1, 0.75f * r);
      triangle(c.x - 0.35f * r, -1, 0.75f * r);
      bar(c.x - 1.1f * r, 0.14f * r, r * 0.8f);
      break;
    case Icon::kHelp: {
      const ImVec2 size = ImGui::CalcTextSize("?");
      draw.AddText({c.x - 0.5f * size.x, c.y - 0.5f * size.y}, color, "?");
      break;
    }
    case Icon::kCamera:
      draw.AddRect({c.x - r, c.y - 0.6f * r}, {c.x + r, c.y + 0.8f * r}, color, 2.0f, 0, 1.5f);
      draw.AddCircle({c.x, c.y + 0.1f * r}, 0.4f * r, color, 0, 1.5f);
      draw.AddRectFilled({c.x - 0.4f * r, c.y - 0.9f * r}, {c.x + 0.4f * r, c.y - 0.6f * r}, color);
      break;
  }
}

}  // namespace

void LogItem(const FrameContext& context, const std::string& name) {
  if (context.widgets != nullptr) {
    context.widgets->Add(name, ImGui::GetItemRectMin(), ImGui::GetItemRectMax());
  }
}

namespace {

/// Sheets and menus over the window that is being drawn.
std::vector<ImRect> DialogsAbove() {
  const ImGuiContext& state = *ImGui::GetCurrentContext();
  const ImGuiWindow* mine = ImGui::GetCurrentWindowRead()->RootWindow;
  std::vector<ImRect> dialogs;
  bool above = false;  // windows are listed from the back to the front
  for (const ImGuiWindow* window : state.Windows) {
    const bool own =
        window->RootWindow == window &&
        (window->Flags & (ImGuiWindowFlags_Tooltip | ImGuiWindowFlags_ChildWindow)) == 0;
    if (above && own && window->WasActive && !window->Hidden) dialogs.push_back(window->Rect());
    above = above || window == mine;
  }
  return dialogs;
}

/// Where a tooltip of this size explains something without lying over it or over a dialog: below,
/// above or beside it, from `from` on along its side. Nothing if there is no such place.
std::optional<ImVec2> PlaceOfTooltip(const FrameContext& context, const ImRect& item, ImVec2 from,
                                     ImVec2 size) {
  const ImVec2 display = ImGui::GetIO().DisplaySize;
  const float gap = context.Scaled(5);
  const std::vector<ImRect> dialogs = DialogsAbove();
  const float x = std::max(gap, std::min(from.x, display.x - size.x - gap));
  const float y = std::max(gap, std::min(from.y, display.y - size.y - gap));
  for (const ImVec2 low : {ImVec2(x, item.Max.y + gap), ImVec2(x, item.Min.y - gap - size.y),
                           ImVec2(item.Max.x + gap, y), ImVec2(item.Min.x - gap - size.x, y)}) {
    const ImRect place(low, {low.x + size.x, low.y + size.y});
    const bool inside = low.x >= 0 && low.y >= 0 && place.Max.x <= display.x &&
                        place.Max.y <= display.y && !place.Overlaps(item);
    const bool free = std::none_of(dialogs.begin(), dialogs.end(),
                                   [&](const ImRect& other) { return place.Overlaps(other); });
    if (inside && free) return low;
  }
  return std::nullopt;
}

}  // namespace

void Tooltip(const FrameContext& context, const std::string& text) {
  if (text.empty() || !ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled)) return;
  const float wrap = context.Scaled(380);
  // What is large, such as a picture, is explained beside the mouse.
  if (ImGui::GetItemRectSize().y < context.Scaled(64)) {
    const ImVec2 words = ImGui::CalcTextSize(text.c_str(), nullptr, false, wrap);
    const ImRect item(ImGui::GetItemRectMin(), ImGui::GetItemRectMax());
    const auto low =
        PlaceOfTooltip(context, item, item.Min,
                       {words.x + 2 * context.Scaled(10), words.y + 2 * context.Scaled(7)});
    if (!low) return;
    ImGui::SetNextWindowPos(*low);
  }
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {context.Scaled(10), context.Scaled(7)});
  ImGui::PushStyleVar(ImGuiStyleVar_Alpha, 1);  // also where what it explains is disabled
  ImGui::BeginTooltip();
  ImGui::PushTextWrapPos(wrap);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::EndTooltip();
  ImGui::PopStyleVar(2);
}

void PutTooltipBeside(const FrameContext& context, ImVec2 low, ImVec2 high) {
  // Of the last one, which is this one but in its first frame, and that is not shown.
  const ImGuiWindow* last = ImGui::FindWindowByName("##Tooltip_00");
  const ImVec2 size =
      last != nullptr ? last->Size : ImVec2(context.Scaled(240), context.Scaled(40));
  const auto place = PlaceOfTooltip(context, {low, high}, ImGui::GetIO().MousePos, size);
  if (place) ImGui::SetNextWindowPos(*place);
}

void PutTooltipBesideMouse(const FrameContext& context) {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const float around = context.Scaled(16);
  PutTooltipBeside(context, {mouse.x - around, mouse.y - around},
                   {mouse.x + around, mouse.y + around});
}

bool Button(const FrameContext& context, const std::string& name, const char* label,
            const std::string& tooltip) {
  const bool clicked = ImGui::Button((std::string(label) + "###" + name).c_str());
  LogItem(context, name);
  Tooltip(context, tooltip);
  return clicked;
}

bool IconButton(const FrameContext& context, const std::string& name, Icon icon, bool on,
                const std::string& tooltip) {
  const float size = ImGui::GetFrameHeight() + context.Scaled(4);
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const bool clicked = ImGui::InvisibleButton(name.c_str(), {size, size});
  const bool hovered = ImGui::IsItemHovered();
  if (on || hovered) {
    ImGui::GetWindowDrawList()->AddRectFilled(
        low, {low.x + size, low.y + size},
        on ? (hovered ? Mixed(colors::kAccent, IM_COL32_WHITE, 0.15) : colors::kAccent)
           : colors::kControlHovered,
        context.Scaled(6));
  }
  DrawIcon(icon, {low.x + 0.5f * size, low.y + 0.5f * size}, context.Scaled(7),
           on ? colors::kBackground : colors::kText);
  LogItem(context, name);
  Tooltip(context, tooltip);
  return clicked;
}

float ToggleWidth(const FrameContext& context, const char* label) {
  ImGui::PushFont(context.fonts.small);
  const float width = ImGui::CalcTextSize(label).x + context.Scaled(16);
  ImGui::PopFont();
  return width;
}

bool Toggle(const FrameContext& context, const std::string& name, const char* label, bool& value,
            const std::string& tooltip) {
  ImGui::PushFont(context.fonts.small);
  const ImVec2 size(ToggleWidth(context, label), ImGui::GetTextLineHeight() + context.Scaled(8));
  const ImVec2 low = ImGui::GetCursorScreenPos();
  const bool clicked = ImGui::InvisibleButton(name.c_str(), size);
  const bool hovered = ImGui::IsItemHovered();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImVec2 high(low.x + size.x, low.y + size.y);
  if (value || hovered) {
    draw.AddRectFilled(low, high, value ? colors::kAccentDim : colors::kControl, context.Scaled(5));
  }
  const ImVec2 text = ImGui::CalcTextSize(label);
  draw.AddText({low.x + 0.5f * (size.x - text.x), low.y + 0.5f * (size.y - text.y)},
               value ? colors::kText : colors::kDimText, label);
  ImGui::PopFont();
  LogItem(context, name);
  Tooltip(context, tooltip);
  if (clicked) value = !value;
  return clicked;
}

void AlignRight(float width) {
  const float room = ImGui::GetContentRegionAvail().x - width;
  if (room > 0) ImGui::SetCursorPosX(ImGui::GetCursorPosX() + room);
}

void EmptyState(const FrameContext& context, const char* title, const char* advice) {
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const ImVec2 origin = ImGui::GetCursorScreenPos();
  const float wrap = std::max(room.x - context.Scaled(32), context.Scaled(80));
  ImGui::PushFont(context.fonts.small);
  const ImVec2 advice_size = ImGui::CalcTextSize(advice, nullptr, false, wrap);
  ImGui::PopFont();
  const ImVec2 title_size = ImGui::CalcTextSize(title);
  const float height = title_size.y + context.Scaled(4) + advice_size.y;
  const float top = origin.y + std::max(0.0f, 0.5f * (room.y - height));
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect(origin, {origin.x + room.x, origin.y + room.y}, true);
  draw.AddText({origin.x + 0.5f * (room.x - title_size.x), top}, colors::kDimText, title);
  draw.AddText(context.fonts.small, context.fonts.small->FontSize,
               {origin.x + 0.5f * (room.x - advice_size.x), top + title_size.y + context.Scaled(4)},
               colors::kFaint, advice, nullptr, wrap);
  draw.PopClipRect();
}

void Bar(ImVec2 size, double share, ImU32 color) {
  const ImVec2 low = ImGui::GetCursorScreenPos();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float rounding = 0.35f * size.y;
  draw.AddRectFilled(low, {low.x + size.x, low.y + size.y}, colors::kInset, rounding);
  const auto width = static_cast<float>(size.x * std::clamp(share, 0.0, 1.0));
  if (width >= 1) {
    draw.AddRectFilled(low, {low.x + width, low.y + size.y}, color,
                       std::min(rounding, 0.5f * width));
  }
  ImGui::Dummy(size);
}

namespace {

/// @return Its width with the room behind it.
float PaintChip(const FrameContext& context, ImDrawList& draw, ImVec2 low, float line, ImU32 color,
                bool halved) {
  const float side = std::round(0.72f * line), top = low.y + std::round(0.5f * (line - side));
  const ImVec2 a(low.x, top), b(low.x + side, top + side);
  draw.AddRectFilled(a, b, color, 0.2f * side);
  const ImU32 edge = Mixed(OnPanel(color), IM_COL32_BLACK, 0.45);
  if (halved) draw.AddTriangleFilled({a.x, b.y}, b, {b.x, a.y}, edge);
  if (context.light) draw.AddRect(a, b, edge, 0.2f * side);
  return side + std::round(0.35f * line);
}

}  // namespace

void Chip(const FrameContext& context, ImU32 color) {
  const float line = ImGui::GetTextLineHeight();
  const float width = PaintChip(context, *ImGui::GetWindowDrawList(), ImGui::GetCursorScreenPos(),
                                line, color, false);
  ImGui::Dummy({width, line});
  ImGui::SameLine(0, 0);
}

void Chip(const FrameContext& context, ObjectId object) {
  const float line = ImGui::GetTextLineHeight();
  const float width = PaintChip(context, *ImGui::GetWindowDrawList(), ImGui::GetCursorScreenPos(),
                                line, context.ColorOf(object), context.LookOf(object).dashed);
  ImGui::Dummy({width, line});
  ImGui::SameLine(0, 0);
}

float DrawChip(const FrameContext& context, ImDrawList& draw, ImVec2 low, ObjectId object) {
  return PaintChip(context, draw, low, context.fonts.small->FontSize, context.ColorOf(object),
                   context.LookOf(object).dashed);
}

void Polyline(const FrameContext& context, ImDrawList& draw, std::span<const ImVec2> points,
              ImU32 color, float width, bool dashed) {
  if (!dashed) {
    draw.AddPolyline(points.data(), static_cast<int>(points.size()), color, 0, width);
    return;
  }
  const float dash = std::max(context.Scaled(5), 2.5f * width), gap = 0.7f * dash;
  bool ink = true;
  float left = dash;
  for (std::size_t i = 1; i < points.size(); ++i) {
    const ImVec2 from = points[i - 1], d(points[i].x - from.x, points[i].y - from.y);
    const float length = std::hypot(d.x, d.y);
    const auto point = [&](float s) {
      return ImVec2(from.x + d.x * s / length, from.y + d.y * s / length);
    };
    for (float s = 0; s < length;) {
      const float step = std::min(left, length - s);
      if (ink) draw.AddLine(point(s), point(s + step), color, width);
      s += step;
      left -= step;
      if (left > 0) continue;
      ink = !ink;
      left = ink ? dash : gap;
    }
  }
}

void DimText(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  ImGui::PushStyleColor(ImGuiCol_Text, colors::kDimText);
  ImGui::TextV(format, arguments);
  ImGui::PopStyleColor();
  va_end(arguments);
}

void SmallText(const FrameContext& context, ImU32 color, const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  ImGui::PushFont(context.fonts.small);
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  ImGui::TextV(format, arguments);
  ImGui::PopStyleColor();
  ImGui::PopFont();
  va_end(arguments);
}

void WrappedText(ImU32 color, const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  ImGui::TextWrapped("%s", text.c_str());
  ImGui::PopStyleColor();
}

void TableRow(const char* name, const std::string& value, const std::string& more) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  DimText("%s", name);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(value.c_str());
  ImGui::TableNextColumn();
  DimText("%s", more.c_str());
}

ImVec2 PictureLabels::SizeOf(const std::string& text) const {
  ImFont* font = context_.fonts.small;
  const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e6f, 0, text.c_str());
  return {size.x + context_.Scaled(8), size.y + context_.Scaled(4)};
}

float PictureLabels::Covered(const Placed& rect) const {
  float area = 0;
  for (const Placed& other : placed_) {
    const float x = std::min(rect.high.x, other.high.x) - std::max(rect.low.x, other.low.x);
    const float y = std::min(rect.high.y, other.high.y) - std::max(rect.low.y, other.low.y);
    if (x > 0 && y > 0) area += x * y;
  }
  return area;
}

namespace {

/// Colours of the light theme's text are too dark for the dark ground of a label.
ImU32 ReadableOnDark(ImU32 color) {
  const cv::Vec3b bgr = BgrOf(color);
  const double luma = 0.114 * bgr[0] + 0.587 * bgr[1] + 0.299 * bgr[2];
  return luma < 80 ? Mixed(color, IM_COL32_WHITE, 0.6) : color;
}

}  // namespace

bool PictureLabels::Add(std::initializer_list<ImVec2> corners, ImU32 color, const std::string& text,
                        Need need) {
  const ImVec2 size = SizeOf(text);
  Placed best;
  float best_area = std::numeric_limits<float>::infinity();
  for (const ImVec2& corner : corners) {
    ImVec2 low(corner.x, corner.y - size.y);
    low.x = std::max(std::min(low.x, clip_high_.x - size.x), clip_low_.x);
    low.y = std::max(std::min(low.y, clip_high_.y - size.y), clip_low_.y);
    const Placed rect{low, {low.x + size.x, low.y + size.y}};
    const float area = Covered(rect);
    if (area < best_area) {
      best = rect;
      best_area = area;
    }
  }
  constexpr float kMostShare = 1.0f / 6;
  const float picture = (clip_high_.x - clip_low_.x) * (clip_high_.y - clip_low_.y);
  if (need == Need::kIfFree && (best_area > 0 || area_ + size.x * size.y > kMostShare * picture))
    return false;
  placed_.push_back(best);
  area_ += size.x * size.y;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddRectFilled(best.low, best.high, IM_COL32(12, 14, 17, 200), context_.Scaled(3));
  draw.AddText(context_.fonts.small, context_.fonts.small->FontSize,
               {best.low.x + context_.Scaled(4), best.low.y + context_.Scaled(2)},
               ReadableOnDark(color), text.c_str());
  return true;
}

}  // namespace plumbline
