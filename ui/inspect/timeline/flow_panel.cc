// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/flow_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

/// A step of the mapper and where it stands in the drawing, in shares.
struct Node {
  const char* name;
  const char* stage;  ///< Of FrameReport::timings; "": costs nothing of its own.
  float x, y;
  ImU32 color;
};
constexpr ImU32 kEdgePath = IM_COL32(82, 168, 224, 255),
                kDetectorPath = IM_COL32(236, 184, 84, 255), kFilter = IM_COL32(94, 201, 142, 255);
constexpr Node kNodes[] = {
    {"Image", "decode", 0.06f, 0.5f, colors::kOnPictureDim},
    {"Edges", "edges", 0.22f, 0.32f, kEdgePath},
    {"Search table", "search table", 0.38f, 0.36f, kEdgePath},
    {"Detector", "detect", 0.22f, 0.70f, kDetectorPath},
    {"Proposals", "explain", 0.38f, 1.00f, kDetectorPath},
    {"Visibility", "visibility", 0.38f, 0.00f, kFilter},
    {"Weigh", "weigh", 0.56f, 0.42f, kFilter},
    {"Spawn", "spawn", 0.56f, 1.00f, kFilter},
    {"Search", "search", 0.74f, 0.42f, kFilter},
    {"Map", "", 0.92f, 0.5f, colors::kOnPictureDim},
};
constexpr int kLinks[][2] = {{0, 1}, {1, 2}, {0, 3}, {3, 4}, {2, 6}, {3, 6},
                             {5, 6}, {4, 7}, {6, 8}, {8, 9}, {7, 9}};

class FlowPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink&) override {
    if (DrawWaiting(context)) return;
    const ImVec2 low = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImVec2 half(std::min(context.Scaled(74), 0.068f * room.x),
                      std::min(context.Scaled(26), 0.11f * room.y));
    const auto center = [&](const Node& node) {
      return ImVec2(low.x + node.x * room.x, low.y + half.y + node.y * (room.y - 2 * half.y));
    };
    for (const auto& [from, to] : kLinks) {
      const ImVec2 a = center(kNodes[from]), b = center(kNodes[to]);
      const ImVec2 start(a.x + half.x, a.y), end(b.x - half.x, b.y);
      const float bend = 0.5f * (end.x - start.x);
      draw.AddBezierCubic(start, {start.x + bend, start.y}, {end.x - bend, end.y}, end,
                          WithAlpha(kNodes[from].color, 0.8), context.Scaled(2));
      const float size = context.Scaled(5);
      draw.AddTriangleFilled({end.x - size, end.y - size}, {end.x, end.y},
                             {end.x - size, end.y + size}, kNodes[from].color);
    }
    for (const Node& node : kNodes) DrawNode(context, node, center(node), half);
  }

 private:
  static void DrawNode(const FrameContext& context, const Node& node, ImVec2 center, ImVec2 half) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImVec2 low(center.x - half.x, center.y - half.y),
        high(center.x + half.x, center.y + half.y);
    draw.AddRectFilled(low, high, colors::kControl, context.Scaled(6));
    draw.AddRect(low, high, node.color, context.Scaled(6), 0, context.Scaled(1.5));
    std::string below = Milliseconds(context, node.stage);
    if (*node.stage == '\0')
      below = fmt::format("{} objects", context.snapshot->report.objects.size());
    const auto text = [&](ImFont* font, float y, ImU32 color, const std::string& words) {
      const ImVec2 size = font->CalcTextSizeA(font->FontSize, 1e6f, 0, words.c_str());
      draw.AddText(font, font->FontSize, {center.x - 0.5f * size.x, y}, color, words.c_str());
    };
    const float line = context.fonts.small->FontSize;
    text(context.fonts.strong, center.y - line - context.Scaled(3), colors::kText, node.name);
    text(context.fonts.small, center.y + context.Scaled(2), colors::kDimText, below);
  }

  static std::string Milliseconds(const FrameContext& context, std::string_view stage) {
    for (const StageTiming& timing : context.snapshot->report.timings) {
      if (timing.stage == stage) return fmt::format("{:.1f} ms", timing.milliseconds);
    }
    return "\u2212";
  }
};

}  // namespace

std::unique_ptr<Panel> MakeFlowPanel() { return std::make_unique<FlowPanel>(); }

}  // namespace plumbline
