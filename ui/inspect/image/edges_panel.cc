// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/edges_panel.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "engine/snapshot/frame_analysis.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
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
    const std::string beside = BesideLabel();
    AlignRight(ToggleWidth(context, beside.c_str()) + ToggleWidth(context, "Outlines") +
               ToggleWidth(context, "Contour") + ToggleWidth(context, "Expected") +
               context.Scaled(12));
    bool on = beside_ > 0;
    if (Toggle(context, "edges.beside", beside.c_str(), on,
               "Other edges of the same image right of a line, which the mouse drags. Each click "
               "takes the next: builtin, builtin-half, gradient, none."))
      beside_ = (beside_ + 1) % static_cast<int>(std::size(kBeside));
    ImGui::SameLine();
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

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const MapSnapshot& snapshot = *context.snapshot;
    if (beside_ > 0) sink.Post(NeedCommand{NeedCommand::What::kOtherEdges, kBeside[beside_]});
    if (snapshot.edge_probability.empty()) {
      return EmptyState(context, "No edge map",
                        "Edges come with live mapping; open the sequence instead of the run.");
    }
    // Lines of one pixel would break up where the map is shown much smaller than it is.
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const float shown = context.viewport->zoom *
                        std::min(room.x / static_cast<float>(snapshot.edge_probability.cols),
                                 room.y / static_cast<float>(snapshot.edge_probability.rows));
    const bool thick = shown < 0.6f;
    const char* name = difference_ ? "edges, expected" : thick ? "edges, thick" : "edges";
    const std::vector<ObjectId> left_out = LeftOut(context);
    const std::uint64_t version =
        difference_ ? VersionOfShown(context, left_out) : context.snapshot_version;
    const ImTextureID texture = context.textures->Get(name, version, [&] {
      return difference_ ? EdgeDifferencePicture(snapshot, left_out)
                         : EdgePicture(snapshot.edge_probability, snapshot.edge_angle, thick);
    });
    const ImageCanvas canvas(context, "edges.view", texture, snapshot.edge_probability.cols,
                             snapshot.edge_probability.rows);
    if (beside_ > 0) {
      DrawBeside(context, canvas, thick);
      DrawBlinkSwitch(context, canvas);
    }
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
      if (probability > 0) {
        PutTooltipBesideMouse(context);
        ImGui::SetTooltip("edge probability %.0f %%", probability / 2.55);
      }
    }
  }

  nlohmann::json SaveState() const override {
    return {{"outlines", outlines_}, {"contour", contour_}, {"difference", difference_},
            {"beside", beside_},     {"divider", divider_}, {"blink", blink_}};
  }
  void LoadState(const nlohmann::json& json) override {
    outlines_ = KeptValue(json, "outlines", outlines_);
    contour_ = KeptValue(json, "contour", contour_);
    difference_ = KeptValue(json, "difference", difference_);
    beside_ =
        std::clamp(KeptValue(json, "beside", beside_), 0, static_cast<int>(std::size(kBeside)) - 1);
    divider_ = std::clamp(KeptValue(json, "divider", divider_), 0.0f, 1.0f);
    blink_ = KeptValue(json, "blink", blink_);
  }

 private:
  static constexpr const char* kBeside[] = {"", "builtin", "builtin-half", "gradient"};

  std::string BesideLabel() const {
    return beside_ == 0 ? "Beside" : std::string("Beside: ") + kBeside[beside_];
  }

  /// A switch in the picture's lower left corner.
  void DrawBlinkSwitch(const FrameContext& context, const ImageCanvas& canvas) {
    const ImVec2 before = ImGui::GetCursorScreenPos();
    ImGui::SetCursorScreenPos({canvas.low().x + context.Scaled(3),
                               canvas.high().y - ImGui::GetFrameHeight() - context.Scaled(3)});
    Toggle(context, "edges.blink", "Blink", blink_,
           "Show one and the other in turn instead of side by side.");
    ImGui::SetCursorScreenPos(before);
  }

  /// The other edges over the right part of the canvas, or over all of it in turn.
  void DrawBeside(const FrameContext& context, const ImageCanvas& canvas, bool thick) {
    const bool ready = context.analysis != nullptr && context.analysis->other_edges &&
                       context.analysis->other_edges->choice == kBeside[beside_];
    const ImVec2 low = canvas.low(), high = canvas.high();
    PictureLabels labels(context, low, high);
    const float below = low.y + labels.SizeOf("run").y;
    if (!ready || !context.analysis->other_edges->problem.empty()) {
      labels.Add({{low.x, below}}, colors::kWarning,
                 ready ? context.analysis->other_edges->problem : "finding edges ..");
      return;
    }
    const OtherEdges& other = *context.analysis->other_edges;
    constexpr double kBlink_s = 0.7;
    const bool turn = std::fmod(ImGui::GetTime(), 2 * kBlink_s) >= kBlink_s;
    if (blink_ && !turn) {
      labels.Add({{low.x, below}}, colors::kText, "run");
      return;
    }
    const float at = blink_ ? low.x : DragDivider(context, low, high);
    const std::string name =
        std::string("edges beside, ") + other.choice + (thick ? ", thick" : "");
    const ImTextureID texture = context.textures->Get(name, context.snapshot_version, [&] {
      return EdgePicture(other.probability, other.angle, thick);
    });
    canvas.draw().PushClipRect({at, low.y}, high, true);
    const auto width = static_cast<float>(other.probability.cols);
    const auto height = static_cast<float>(other.probability.rows);
    canvas.draw().AddImage(texture, canvas.ToScreen(-0.5f, -0.5f),
                           canvas.ToScreen(width - 0.5f, height - 0.5f));
    canvas.draw().PopClipRect();
    labels.Add({{at + context.Scaled(3), below}}, colors::kText, other.choice);
    if (blink_) return;
    labels.Add({{low.x, below}}, colors::kText, "run");
    canvas.draw().AddLine({at, low.y}, {at, high.y}, IM_COL32(235, 238, 242, 200),
                          context.Scaled(1.5));
  }

  /// Where the line between the two stands on the screen, after the mouse has had its way.
  float DragDivider(const FrameContext& context, ImVec2 low, ImVec2 high) {
    const float width = std::max(1.0f, high.x - low.x), reach = context.Scaled(5);
    const ImVec2 before = ImGui::GetCursorScreenPos();
    ImGui::SetCursorScreenPos({low.x + divider_ * width - reach, low.y});
    ImGui::InvisibleButton("##edges.divider", {2 * reach, std::max(1.0f, high.y - low.y)});
    LogItem(context, "edges.divider");
    if (ImGui::IsItemHovered() || ImGui::IsItemActive())
      ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeEW);
    if (ImGui::IsItemActive())
      divider_ = std::clamp((ImGui::GetMousePos().x - low.x) / width, 0.0f, 1.0f);
    ImGui::SetCursorScreenPos(before);
    return low.x + divider_ * width;
  }

  bool outlines_ = false, contour_ = false, difference_ = false, blink_ = false;
  int beside_ = 0;  ///< Index into kBeside.
  float divider_ = 0.5f;
};

}  // namespace

std::unique_ptr<Panel> MakeEdgesPanel() { return std::make_unique<EdgesPanel>(); }

}  // namespace plumbline
