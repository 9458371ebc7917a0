// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/depth_panel.h"

#include <fmt/format.h>

#include <algorithm>

#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/framework/image_canvas.h"
#include "ui/framework/pictures.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/image/overlays.h"

namespace plumbline {
namespace {

void DrawScale(const FrameContext& context, const ImageCanvas& canvas, const DepthRange& range) {
  const float picture = canvas.high().x - canvas.low().x;
  const float height = context.Scaled(7), pad = context.Scaled(7);
  const float text = context.fonts.small->FontSize;
  const auto words = [](double depth_m) { return fmt::format("{:.1f} m", depth_m); };
  const auto width_of = [&](const std::string& label) {
    return context.fonts.small->CalcTextSizeA(text, 1e6f, 0, label.c_str()).x;
  };
  // Narrow pictures give more of their width, so that the two ends can be read.
  const float ends = width_of(words(range.near_m)) + width_of(words(range.far_m)) + pad;
  const float width = std::max(ends, std::min(context.Scaled(150), 0.5f * picture));
  if (width > picture - 2 * pad) return;
  const ImVec2 low(canvas.high().x - width - pad, canvas.high().y - height - text - 2 * pad);
  canvas.draw().AddRectFilled({low.x - 0.5f * pad, low.y - pad},
                              {canvas.high().x - pad * 0.5f, canvas.high().y - pad * 0.5f},
                              IM_COL32(12, 14, 17, 200), context.Scaled(3));
  constexpr int kSteps = 48;
  for (int i = 0; i < kSteps; ++i) {
    const float x0 = low.x + width * static_cast<float>(i) / kSteps;
    const double depth = range.near_m + (range.far_m - range.near_m) * (i + 0.5) / kSteps;
    canvas.draw().AddRectFilled({x0, low.y}, {x0 + width / kSteps + 1, low.y + height},
                                DepthColor(depth, range));
  }
  const auto put = [&](double share, double depth_m, float align) {
    const std::string label = words(depth_m);
    canvas.draw().AddText(
        context.fonts.small, text,
        {low.x + width * static_cast<float>(share) - align * width_of(label), low.y + height + 1},
        colors::kOnPicture, label.c_str());
  };
  put(0, range.near_m, 0);
  if (width > context.Scaled(120)) put(0.5, 0.5 * (range.near_m + range.far_m), 0.5f);
  put(1, range.far_m, 1);
}

class DepthPanel : public Panel {
 public:
  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const MapSnapshot& snapshot = *context.snapshot;
    if (snapshot.depth.empty()) {
      return EmptyState(context, "No Z-buffer", "Shown once the map holds an object.");
    }
    const std::vector<ObjectId> left_out = LeftOut(context);
    const cv::Mat shown = WithoutObjects(snapshot.depth, snapshot.id, left_out);
    const DepthRange range = RangeOf(shown);
    if (range.empty() && !RangeOf(snapshot.depth).empty())
      return EmptyState(context, "No confirmed object in view",
                        "'Confirmed only' in the top bar (C) leaves out the others.");
    if (range.empty())
      return EmptyState(context, "No object in view", "Keep playing until one is found.");
    const ImTextureID texture = context.textures->Get("depth", VersionOfShown(context, left_out),
                                                      [&] { return DepthPicture(shown, range); });
    const ImageCanvas canvas(context, "depth.view", texture, snapshot.depth.cols,
                             snapshot.depth.rows);
    DrawScale(context, canvas, range);
    const auto pixel = canvas.hovered();
    if (!pixel) return;
    const int x = static_cast<int>(pixel->x() + 0.5f), y = static_cast<int>(pixel->y() + 0.5f);
    if (x < 0 || y < 0 || x >= snapshot.depth.cols || y >= snapshot.depth.rows) return;
    const float depth = shown.at<float>(y, x);
    const int id = snapshot.id.empty() || depth <= 0 ? 0 : snapshot.id.at<std::uint16_t>(y, x);
    if (depth > 0) {
      PutTooltipBesideMouse(context);
      ImGui::SetTooltip("%.2f m, object #%d", depth, id);
    }
    if (canvas.clicked()) sink.Post(SelectObjectCommand{id > 0 ? ObjectId{id} : ObjectId{}});
  }
};

}  // namespace

std::unique_ptr<Panel> MakeDepthPanel() { return std::make_unique<DepthPanel>(); }

}  // namespace plumbline
