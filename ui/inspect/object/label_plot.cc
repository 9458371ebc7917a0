// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/object/label_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

/// The plot without its legend.
struct Area {
  ImVec2 low, high;
  int first = 0, last = 1;  ///< Frames at its sides.
  float XOf(double frame) const {
    return low.x +
           static_cast<float>((frame - first) / std::max(1, last - first)) * (high.x - low.x);
  }
  float YOf(double share) const { return high.y - static_cast<float>(share) * (high.y - low.y); }
};

ImU32 LabelColor(std::size_t index) { return OnPanel(SeriesColor(index)); }

std::string NameOf(const FrameContext& context, ModelId label) {
  const ModelView* model = context.Model(label);
  return model != nullptr ? model->name : fmt::format("shape {}", label.value);
}

void Words(const FrameContext& context, ImVec2 at, ImU32 color, const std::string& words) {
  ImFont* font = context.fonts.small;
  ImGui::GetWindowDrawList()->AddText(font, font->FontSize, at, color, words.c_str());
}

/// One column of the screen for every frame, or for every pixel where there are more frames.
void DrawAreas(const LabelHistory& history, const Area& area) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect(area.low, area.high, true);
  const std::size_t stride = std::max<std::size_t>(
      1,
      history.frames.size() / static_cast<std::size_t>(std::max(1.0f, area.high.x - area.low.x)));
  for (std::size_t i = 0; i < history.frames.size(); i += stride) {
    const LabelHistory::Frame& frame = history.frames[i];
    const std::size_t next = std::min(i + stride, history.frames.size() - 1);
    // A frame lasts up to the next one, or, before a gap, for one frame.
    const int until =
        next > i ? std::min(history.frames[next].frame, frame.frame + 4 * static_cast<int>(stride))
                 : frame.frame + 1;
    const float x0 = std::round(area.XOf(frame.frame));  // whole pixels: no seams
    const float x1 = std::max(x0 + 1, std::round(area.XOf(until)));
    double below = 0;
    for (std::size_t k = 0; k < frame.probability.size(); ++k) {
      const double share = frame.probability[k];
      draw.AddRectFilled({x0, area.YOf(below + share)}, {x1, area.YOf(below)},
                         Mixed(LabelColor(k), colors::kInset, 0.2));
      below += share;
    }
  }
  draw.PopClipRect();
}

/// Beside the plot: a square and a name each, with the probability in the frame that is shown.
void DrawLegend(const FrameContext& context, const LabelHistory& history, ImVec2 corner,
                float width, const LabelHistory::Frame* now) {
  const float line = context.fonts.small->FontSize + context.Scaled(3);
  const float square = 0.6f * context.fonts.small->FontSize;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect(corner, {corner.x + width, corner.y + 1000}, true);
  for (std::size_t k = 0; k < history.labels.size(); ++k) {
    const float y = corner.y + line * static_cast<float>(k);
    draw.AddRectFilled({corner.x, y + 0.2f * line}, {corner.x + square, y + 0.2f * line + square},
                       LabelColor(k));
    Words(context, {corner.x + square + context.Scaled(6), y}, colors::kText,
          now != nullptr ? fmt::format("{:.0f} %  {}", 100 * now->probability[k],
                                       NameOf(context, history.labels[k]))
                         : NameOf(context, history.labels[k]));
  }
  draw.PopClipRect();
}

const LabelHistory::Frame* Nearest(const LabelHistory& history, int frame) {
  const auto after =
      std::lower_bound(history.frames.begin(), history.frames.end(), frame,
                       [](const LabelHistory::Frame& at, int wanted) { return at.frame < wanted; });
  if (after == history.frames.end())
    return history.frames.empty() ? nullptr : &history.frames.back();
  return &*after;
}

void DrawHint(const FrameContext& context, const LabelHistory& history,
              const LabelHistory::Frame& frame) {
  PutTooltipBeside(context, ImGui::GetItemRectMin(), ImGui::GetItemRectMax());
  ImGui::BeginTooltip();
  ImGui::Text("Frame %d", frame.frame);
  double rest = 1;
  for (std::size_t k = 0; k < history.labels.size(); ++k) {
    rest -= frame.probability[k];
    ImGui::PushStyleColor(ImGuiCol_Text, LabelColor(k));
    ImGui::Text("%5.1f %%", 100 * frame.probability[k]);
    ImGui::PopStyleColor();
    ImGui::SameLine();
    DimText("%s", NameOf(context, history.labels[k]).c_str());
  }
  if (rest > 0.005) DimText("%5.1f %%  others, never above 5 %%", 100 * rest);
  DimText("A click goes to this frame.");
  ImGui::EndTooltip();
}

}  // namespace

void DrawLabelPlot(const FrameContext& context, const LabelHistory& history, ImVec2 corner,
                   ImVec2 size, CommandSink& sink) {
  const float font = context.fonts.small->FontSize;
  const float legend = std::min(context.Scaled(190), 0.4f * size.x);
  const float axis = context.Scaled(40);
  if (history.frames.empty() || size.y < 4 * font) {
    Words(context, corner, colors::kFaint, "The history of this object has not been read yet.");
    return;
  }
  Area area{{corner.x + axis, corner.y + context.Scaled(4)},
            {corner.x + size.x - legend - context.Scaled(12), corner.y + size.y - font - 2},
            history.frames.front().frame,
            history.frames.back().frame + 1};
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddRectFilled(area.low, area.high, colors::kInset, context.Scaled(2));
  DrawAreas(history, area);
  Words(context, {corner.x, area.low.y - 2}, colors::kFaint, "100 %");
  Words(context, {corner.x, area.high.y - font}, colors::kFaint, "0");
  Words(context, {area.low.x, area.high.y + 1}, colors::kFaint,
        fmt::format("frame {}", area.first));
  const std::string last = fmt::format("{}", area.last - 1);
  Words(context, {area.high.x - ImGui::CalcTextSize(last.c_str()).x, area.high.y + 1},
        colors::kFaint, last);
  const float now = area.XOf(context.playback->frame + 0.5);
  if (now >= area.low.x && now <= area.high.x)
    draw.AddLine({now, area.low.y}, {now, area.high.y}, colors::kText, context.Scaled(1.5));
  DrawLegend(context, history, {corner.x + size.x - legend, area.low.y}, legend,
             Nearest(history, context.playback->frame));
  ImGui::SetCursorScreenPos(area.low);
  ImGui::InvisibleButton("posterior.labels",
                         {std::max(1.0f, area.high.x - area.low.x), area.high.y - area.low.y});
  LogItem(context, "posterior.labels");
  if (!ImGui::IsItemHovered()) return;
  const double share = (ImGui::GetIO().MousePos.x - area.low.x) / (area.high.x - area.low.x);
  const int frame = area.first + static_cast<int>(std::floor(share * (area.last - area.first)));
  const LabelHistory::Frame* under = Nearest(history, frame);
  if (under == nullptr) return;
  DrawHint(context, history, *under);
  if (ImGui::IsItemClicked()) sink.Post(SeekCommand{under->frame});
}

}  // namespace plumbline
