// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/edges_panel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/framework/image_canvas.h"
#include "ui/framework/pictures.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/image/edge_difference.h"
#include "ui/inspect/image/overlays.h"

namespace plumbline {
namespace {

/// A half wheel that says which colour is which direction of the edge itself.
void DrawOrientationLegend(const FrameContext& context, const ImageCanvas& canvas) {
  const float pad = context.Scaled(7);
  const float radius = std::min(context.Scaled(17), 0.13f * (canvas.high().y - canvas.low().y));
  if (canvas.high().x - canvas.low().x < 6 * radius) return;
  const ImVec2 center(canvas.high().x - radius - pad, canvas.high().y - pad);
  canvas.draw().AddRectFilled({center.x - radius - 4, center.y - radius - 4},
                              {center.x + radius + 4, center.y + 4}, IM_COL32(12, 14, 17, 190),
                              context.Scaled(3));
  constexpr int kSpokes = 24;
  for (int i = 0; i < kSpokes; ++i) {
    const double along = std::numbers::pi * (i + 0.5) / kSpokes;  // image y points down
    const double normal = std::fmod(along + 0.5 * std::numbers::pi, std::numbers::pi);
    const ImVec2 tip(center.x + radius * static_cast<float>(std::cos(along)),
                     center.y - radius * static_cast<float>(std::sin(along)));
    canvas.draw().AddLine(center, tip,
                          OrientationColor(std::fmod(std::numbers::pi - normal, std::numbers::pi)),
                          context.Scaled(2));
  }
}

class EdgesPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    AlignRight(ToggleWidth(context, "Outlines") + ToggleWidth(context, "Contour") +
               ToggleWidth(context, "Expected") + context.Scaled(8));
    Toggle(
        context, "edges.difference", "Expected", difference_,
        "Edges against the contours of the mean states: green edges that one explains, grey ones "
        "that none does, red contour without an edge within 5 pixels.");
    ImGui::SameLine();
    Toggle(context, "edges.contour", "Contour", contour_,
           "Contour samples of the hypothesis that is chosen under 'Why here?'.");
    ImGui::SameLine();
    Toggle(context, "edges.outlines", "Outlines", outlines_,
           "Outlines of the mean states over the edges that they should meet.");
  }

  void Draw(const FrameContext& context, CommandSink&) override {
    if (DrawWaiting(context)) return;
    const MapSnapshot& snapshot = *context.snapshot;
    if (snapshot.edge_probability.empty()) {
      return EmptyState(context, "No edge map",
                        "Edges come with live mapping; open the sequence instead of the run.");
    }
    // Lines of one pixel would break up where the map is shown much smaller than it is.
    const float shown = ImGui::GetContentRegionAvail().x * context.viewport->zoom /
                        static_cast<float>(snapshot.edge_probability.cols);
    const bool thick = shown < 0.6f;
    const char* name = difference_ ? "edges, expected" : thick ? "edges, thick" : "edges";
    const ImTextureID texture = context.textures->Get(name, context.snapshot_version, [&] {
      return difference_ ? EdgeDifferencePicture(snapshot)
                         : EdgePicture(snapshot.edge_probability, snapshot.edge_angle, thick);
    });
    const ImageCanvas canvas(context, "edges.view", texture, snapshot.edge_probability.cols,
                             snapshot.edge_probability.rows);
    if (outlines_)
      DrawOutlineOverlay(context, canvas, {.width_px = 1, .alpha = 0.8, .shadow = false});
    if (contour_) DrawContourOverlay(context, canvas);
    if (!difference_) DrawOrientationLegend(context, canvas);
    if (const auto pixel = canvas.hovered()) {
      const int x = static_cast<int>(std::lround(pixel->x())),
                y = static_cast<int>(std::lround(pixel->y()));
      if (x < 0 || y < 0 || x >= snapshot.edge_probability.cols ||
          y >= snapshot.edge_probability.rows)
        return;
      const int probability = snapshot.edge_probability.at<std::uint8_t>(y, x);
      if (probability > 0) ImGui::SetTooltip("edge probability %.0f %%", probability / 2.55);
    }
  }

  nlohmann::json SaveState() const override {
    return {{"outlines", outlines_}, {"contour", contour_}, {"difference", difference_}};
  }
  void LoadState(const nlohmann::json& json) override {
    outlines_ = json.value("outlines", outlines_);
    contour_ = json.value("contour", contour_);
    difference_ = json.value("difference", difference_);
  }

 private:
  bool outlines_ = false, contour_ = false, difference_ = false;
};

}  // namespace

std::unique_ptr<Panel> MakeEdgesPanel() { return std::make_unique<EdgesPanel>(); }

}  // namespace plumbline
