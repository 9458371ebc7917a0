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
  const float width = std::min(context.Scaled(150), 0.5f * (canvas.high().x - canvas.low().x));
  const float height = context.Scaled(7), pad = context.Scaled(7);
  const float text = context.fonts.small->FontSize;
  const ImVec2 low(canvas.high().x - width - 2 * pad, canvas.high().y - height - text - 2 * pad);
  canvas.draw().AddRectFilled({low.x - pad, low.y - pad},
                              {canvas.high().x - pad * 0.5f, canvas.high().y - pad * 0.5f},
                              IM_COL32(12, 14, 17, 200), context.Scaled(3));
  constexpr int kSteps = 48;
  for (int i = 0; i < kSteps; ++i) {
    const float x0 = low.x + width * static_cast<float>(i) / kSteps;
    const double depth = range.near_m + (range.far_m - range.near_m) * (i + 0.5) / kSteps;
    canvas.draw().AddRectFilled({x0, low.y}, {x0 + width / kSteps + 1, low.y + height},
                                DepthColor(depth, range));
  }
  const auto label = [&](double share, double value, float align) {
    const std::string words = fmt::format("{:.1f} m", value);
    const float w = context.fonts.small->CalcTextSizeA(text, 1e6f, 0, words.c_str()).x;
    canvas.draw().AddText(
        context.fonts.small, text,
        {low.x + width * static_cast<float>(share) - align * w, low.y + height + 1},
        colors::kOnPicture, words.c_str());
  };
  label(0, range.near_m, 0);
  if (width > context.Scaled(120)) label(0.5, 0.5 * (range.near_m + range.far_m), 0.5f);
  label(1, range.far_m, 1);
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
