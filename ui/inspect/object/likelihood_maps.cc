// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/likelihood_maps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/framework/pictures.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr const char* kTerms[] = {"Score", "Edges", "Detector"};
constexpr DepthRange kUnit{0, 1};

const std::vector<float>& Values(const LikelihoodMap& map, int term) {
  return term == 1 ? map.phi_edge : term == 2 ? map.phi_cnn : map.score;
}

void Words(const FrameContext& context, ImVec2 at, float align, ImU32 color,
           const std::string& words) {
  ImFont* font = context.fonts.small;
  const float width = font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str()).x;
  ImGui::GetWindowDrawList()->AddText(font, font->FontSize, {at.x - align * width, at.y}, color,
                                      words.c_str());
}

/// Value of the map under the mouse.
void Hint(const FrameContext& context, const LikelihoodMap& map, const std::vector<float>& values,
          const char* term, ImVec2 low, ImVec2 cell) {
  const auto index = [](float at, float size, std::size_t count) {
    return static_cast<std::size_t>(std::clamp(at / size, 0.0f, static_cast<float>(count) - 1.0f));
  };
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const std::size_t x = index(mouse.x - low.x, cell.x, map.x_offsets.size());
  const std::size_t rows = map.y_offsets.size();
  const std::size_t y = rows - 1 - index(mouse.y - low.y, cell.y, rows);
  PutTooltipBeside(context, ImGui::GetItemRectMin(), ImGui::GetItemRectMax());
  ImGui::SetTooltip("%s %+.0f %s, %s %+.0f %s: %s %.2f", map.x_parameter.c_str(), map.x_offsets[x],
                    map.x_unit.c_str(), map.y_parameter.c_str(), map.y_offsets[y],
                    map.y_unit.c_str(), term, values[y * map.x_offsets.size() + x]);
}

void DrawMap(const FrameContext& context, const ProbeView& probe, const LikelihoodMap& map,
             int term, ImVec2 corner, ImVec2 size) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float font = context.fonts.small->FontSize;
  const ImVec2 low(corner.x, corner.y + font + 2),
      high(corner.x + size.x, corner.y + size.y - font);
  if (high.x - low.x < 20 || high.y - low.y < 20) return;
  const std::vector<float>& values = Values(map, term);
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const std::size_t columns = map.x_offsets.size(), rows = map.y_offsets.size();
  const ImVec2 cell((high.x - low.x) / static_cast<float>(columns),
                    (high.y - low.y) / static_cast<float>(rows));
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const float value = values[row * columns + column];
      const double share = *most > *least ? (value - *least) / (*most - *least) : 0;
      const ImVec2 at(low.x + static_cast<float>(column) * cell.x,
                      high.y - static_cast<float>(row + 1) * cell.y);
      draw.AddRectFilled(at, {at.x + cell.x + 0.5f, at.y + cell.y + 0.5f},
                         DepthColor(1 - share, kUnit));
    }
  }
  const auto place = [&](float x, float y) {
    const auto share = [](float v, const std::vector<float>& axis) {
      return (v - axis.front()) / (axis.back() - axis.front());
    };
    return ImVec2(low.x + 0.5f * cell.x + share(x, map.x_offsets) * (high.x - low.x - cell.x),
                  high.y - 0.5f * cell.y - share(y, map.y_offsets) * (high.y - low.y - cell.y));
  };
  const auto cross = [&](ImVec2 at, ImU32 color) {
    const float r = context.Scaled(5);
    for (const auto& [ink, width] : {std::pair(IM_COL32(0, 0, 0, 200), 4.0), {color, 2.0}}) {
      draw.AddLine({at.x - r, at.y}, {at.x + r, at.y}, ink, context.Scaled(width));
      draw.AddLine({at.x, at.y - r}, {at.x, at.y + r}, ink, context.Scaled(width));
    }
  };
  draw.PushClipRect(low, high, true);
  cross(place(0, 0), context.ColorOf(probe.object));
  if (map.truth) cross(place(map.truth->x(), map.truth->y()), colors::kTruth);
  draw.PopClipRect();
  Words(context, corner, 0, colors::kDimText, fmt::format("{} [{}]", map.y_parameter, map.y_unit));
  Words(context, {high.x, corner.y}, 1, colors::kFaint,
        fmt::format("{:.2f} .. {:.2f}", *least, *most));
  Words(context, {low.x, high.y}, 0, colors::kFaint, fmt::format("{:.0f}", map.x_offsets.front()));
  Words(context, {0.5f * (low.x + high.x), high.y}, 0.5f, colors::kDimText,
        fmt::format("{} [{}]", map.x_parameter, map.x_unit));
  Words(context, {high.x, high.y}, 1, colors::kFaint, fmt::format("+{:.0f}", map.x_offsets.back()));
  ImGui::SetCursorScreenPos(low);
  ImGui::InvisibleButton(("why.map." + map.x_parameter).c_str(), {high.x - low.x, high.y - low.y});
  LogItem(context, "why.map." + map.x_parameter);
  if (ImGui::IsItemHovered()) Hint(context, map, values, kTerms[term], low, cell);
}

}  // namespace

void DrawLikelihoodMaps(const FrameContext& context, const ProbeView& probe, int& term) {
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const ImVec2 corner = ImGui::GetCursorScreenPos();
  const float text = ImGui::GetTextLineHeight() + context.Scaled(4);
  if (room.x < 60 || room.y < 60) return;
  if (probe.maps.empty())
    return EmptyState(context, "Scoring", "Two parameters at once: this takes a moment.");
  term = std::clamp(term, 0, 2);
  for (int i = 0; i < 3; ++i) {
    bool on = term == i;
    if (i > 0) ImGui::SameLine(0, context.Scaled(3));
    if (Toggle(context, fmt::format("why.term.{}", i), kTerms[i], on,
               "Which term the colours show: yellow is the highest, violet the lowest. Cross in "
               "the object's colour: the mean; green: the truth."))
      term = i;
  }
  const float top = ImGui::GetItemRectMax().y + context.Scaled(2);
  const float gap = context.Scaled(10);
  const auto count = static_cast<float>(probe.maps.size());
  const ImVec2 size((room.x - (count - 1) * gap) / count, std::max(text, corner.y + room.y - top));
  for (std::size_t i = 0; i < probe.maps.size(); ++i)
    DrawMap(context, probe, probe.maps[i], term,
            {corner.x + static_cast<float>(i) * (size.x + gap), top}, size);
}

}  // namespace plumbline
