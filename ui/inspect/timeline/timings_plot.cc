// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timings_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

/// Means over the frames that fall into one column of the picture.
struct Column {
  int first_frame = 0, last_frame = 0, frames = 0;
  int slowest_frame = 0;
  double slowest_ms = -1;
  std::map<std::string, double> sum_ms;
  double total_ms() const {
    double sum = 0;
    for (const auto& [stage, ms] : sum_ms) sum += ms;
    return frames > 0 ? sum / frames : 0;
  }
};

std::vector<Column> ColumnsOf(const RunHistory& history, std::size_t most,
                              std::vector<std::string>& stages) {
  const std::size_t size = history.frames.size();
  const std::size_t per_column = std::max<std::size_t>(1, (size + most - 1) / most);
  std::vector<Column> columns((size + per_column - 1) / per_column);
  for (std::size_t i = 0; i < size; ++i) {
    const auto& frame = history.frames[i];
    if (frame == nullptr || frame->skipped) continue;
    Column& column = columns[i / per_column];
    if (column.frames++ == 0) column.first_frame = frame->frame;
    column.last_frame = frame->frame;
    double total_ms = 0;
    for (const StageTiming& timing : frame->timings) total_ms += timing.milliseconds;
    if (total_ms > column.slowest_ms) {
      column.slowest_ms = total_ms;
      column.slowest_frame = frame->frame;
    }
    for (const StageTiming& timing : frame->timings) {
      if (std::find(stages.begin(), stages.end(), timing.stage) == stages.end())
        stages.push_back(timing.stage);
      column.sum_ms[timing.stage] += timing.milliseconds;
    }
  }
  return columns;
}

/// Above nearly all columns: a first frame that loads everything would dwarf the rest.
double Ceiling(const std::vector<Column>& columns) {
  std::vector<double> totals;
  for (const Column& column : columns) totals.push_back(column.total_ms());
  if (totals.empty()) return 1;
  const auto at = totals.begin() + static_cast<std::ptrdiff_t>(0.95 * double(totals.size() - 1));
  std::nth_element(totals.begin(), at, totals.end());
  return std::max(1.0, 1.25 * *at);
}

void Hint(const FrameContext& context, const Column& column,
          const std::vector<std::string>& stages) {
  PutTooltipBeside(context, ImGui::GetItemRectMin(), ImGui::GetItemRectMax());
  ImGui::BeginTooltip();
  if (column.frames == 1)
    ImGui::Text("Frame %d: %.1f ms", column.first_frame, column.total_ms());
  else
    ImGui::Text("Frames %d to %d: mean %.1f ms, most %.1f ms in frame %d", column.first_frame,
                column.last_frame, column.total_ms(), column.slowest_ms, column.slowest_frame);
  for (std::size_t i = stages.size(); i-- > 0;) {
    const auto found = column.sum_ms.find(stages[i]);
    if (found == column.sum_ms.end()) continue;
    ImGui::TextColored(ImGui::ColorConvertU32ToFloat4(StageColor(i)), "%s", stages[i].c_str());
    ImGui::SameLine();
    DimText("%.1f ms", found->second / column.frames);
  }
  ImGui::EndTooltip();
}

}  // namespace

ImU32 StageColor(std::size_t index) { return OnPanel(SeriesColor(index)); }

void DrawTimingsPlot(const FrameContext& context, CommandSink& sink) {
  const ImVec2 corner = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
  const float font = ImGui::GetTextLineHeight();
  if (room.x < 60 || room.y < 2.5f * font) return;
  std::vector<std::string> stages;
  const std::vector<Column> columns =
      ColumnsOf(*context.playback->history, static_cast<std::size_t>(room.x / 2), stages);
  if (stages.empty())
    return EmptyState(context, "No frames yet", "Keep playing: each frame adds its times.");
  const ImVec2 low = corner, high(corner.x + room.x, corner.y + room.y - font);
  const double ceiling = Ceiling(columns);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddRectFilled(low, high, colors::kInset, context.Scaled(2));
  draw.PushClipRect(low, high, true);
  const float width = room.x / static_cast<float>(columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const float x0 = low.x + static_cast<float>(c) * width;
    float y = high.y;
    for (std::size_t i = 0; i < stages.size(); ++i) {
      const auto found = columns[c].sum_ms.find(stages[i]);
      if (found == columns[c].sum_ms.end()) continue;
      const auto tall =
          static_cast<float>(found->second / columns[c].frames / ceiling) * (high.y - low.y);
      draw.AddRectFilled({x0, y - tall}, {x0 + std::max(1.0f, width), y}, StageColor(i));
      y -= tall;
    }
    if (columns[c].frames > 1) {  // what the mean hides
      const float y_most =
          high.y - static_cast<float>(columns[c].slowest_ms / ceiling) * (high.y - low.y);
      draw.AddLine({x0, y}, {x0, y_most}, WithAlpha(colors::kDimText, 0.6));
    }
    if (columns[c].frames > 0 && columns[c].first_frame <= context.playback->frame &&
        context.playback->frame <= columns[c].last_frame)
      draw.AddLine({x0, low.y}, {x0, high.y}, colors::kText, context.Scaled(1.5));
  }
  draw.PopClipRect();
  draw.AddText({low.x + 3, low.y}, colors::kDimText, fmt::format("{:.0f} ms", ceiling).c_str());
  draw.AddText({low.x, high.y}, colors::kFaint,
               fmt::format("frame {}", columns.front().first_frame).c_str());
  const std::string last = fmt::format("{}", columns.back().last_frame);
  draw.AddText({high.x - ImGui::CalcTextSize(last.c_str()).x, high.y}, colors::kFaint,
               last.c_str());
  ImGui::InvisibleButton("timings.plot", {room.x, room.y});
  LogItem(context, "timings.plot");
  if (!ImGui::IsItemHovered()) return;
  const auto c = static_cast<std::size_t>(std::clamp((ImGui::GetIO().MousePos.x - low.x) / width,
                                                     0.0f, static_cast<float>(columns.size() - 1)));
  if (columns[c].frames == 0) return;
  Hint(context, columns[c], stages);
  if (ImGui::IsItemClicked()) sink.Post(SeekCommand{columns[c].slowest_frame});
}

}  // namespace plumbline
