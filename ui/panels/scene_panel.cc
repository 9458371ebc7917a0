// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/framework/scene_surface.h"
#include "ui/framework/widgets.h"
#include "ui/panels/panels.h"
#include "ui/panels/waiting.h"

namespace plumbline {
namespace {

struct LayerToggle {
  const char* name;
  const char* label;
  bool SceneLayers::*layer;
  const char* tooltip;
};
constexpr LayerToggle kLayers[] = {
    {"models", "Models", &SceneLayers::models,
     "Mean states of the objects in their colours; tentative ones are translucent."},
    {"particles", "Particles", &SceneLayers::particles,
     "Hypotheses of the selected object: centre and front."},
    {"scan", "Scan", &SceneLayers::scan,
     "Points of the scanned scene, where the sequence has one."},
    {"truth", "Truth", &SceneLayers::truth,
     "True places of the objects in green, where they are known."},
    {"trajectory", "Path", &SceneLayers::trajectory,
     "The camera's path; the part already walked is bright."},
    {"frustum", "Camera", &SceneLayers::frustum, "Where the camera is and what it sees."},
    {"grid", "Grid", &SceneLayers::grid, "Grid on the floor."},
};

class ScenePanel : public Panel {
 public:
  const char* Id() const override { return "scene"; }
  const char* Title() const override { return "Map"; }
  const char* Help() const override {
    return "The map in 3-D. Left drag turns, right drag (or middle, or Shift and left) moves, the "
           "wheel zooms, double "
           "click turns about what is under the mouse, a click selects. F frames the selected "
           "object, R resets.";
  }

  void DrawHeader(const FrameContext& context, CommandSink& sink) override {
    float width =
        ToggleWidth(context, "Follow") + ToggleWidth(context, "Through") + context.Scaled(17);
    for (const LayerToggle& layer : kLayers) {
      width += ToggleWidth(context, layer.label) + context.Scaled(3);
    }
    if (width <= ImGui::GetContentRegionAvail().x) {
      AlignRight(width);
      DrawLayerToggles(context, false);
    } else {
      AlignRight(ToggleWidth(context, "Layers") + ToggleWidth(context, "Follow") +
                 ToggleWidth(context, "Through") + context.Scaled(17));
      bool open = false;
      if (Toggle(context, "scene.layers", "Layers", open, "What the map shows."))
        ImGui::OpenPopup("layers");
      if (ImGui::BeginPopup("layers")) {
        DrawLayerToggles(context, true);
        ImGui::EndPopup();
      }
    }
    ImGui::SameLine(0, context.Scaled(12));
    bool follow = context.follow;
    if (Toggle(context, "scene.follow", "Follow", follow,
               "The view stays behind the moving camera.")) {
      sink.Post(FollowCommand{follow});
    }
    ImGui::SameLine(0, context.Scaled(3));
    bool through = context.look_through;
    if (Toggle(context, "scene.through", "Through", through,
               "Looks through the camera, with its image behind the models (0)."))
      sink.Post(LookThroughCommand{through});
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    if (context.scene == nullptr) {
      return EmptyState(context, "No 3-D view", "This display has no OpenGL that VTK can use.");
    }
    context.scene->SetContent({context.sequence, context.snapshot, context.snapshot_version,
                               context.selection.object, context.selection.particle, layers_,
                               context.follow, context.look_through, context.light});
    const ImVec2 low = ImGui::GetCursorScreenPos();
    const ImVec2 size = ImGui::GetContentRegionAvail();
    const int width = std::max(8, static_cast<int>(size.x)),
              height = std::max(8, static_cast<int>(size.y));
    ImGui::InvisibleButton("scene.view", {static_cast<float>(width), static_cast<float>(height)},
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                               ImGuiButtonFlags_MouseButtonMiddle);
    LogItem(context, "scene.view");
    const bool moving = HandleMouse(*context.scene, low, sink);
    const bool playing = context.playback->state == PlaybackState::kPlaying;
    const ImTextureID texture = context.scene->Texture(width, height, moving || playing);
    const ImVec2 high(low.x + static_cast<float>(width), low.y + static_cast<float>(height));
    ImGui::GetWindowDrawList()->AddImageRounded(texture, low, high, {0, 1}, {1, 0}, IM_COL32_WHITE,
                                                context.Scaled(4));
    DrawTriad(context, low, high);
    if (layers_.grid && !context.look_through) DrawGridLabel(context, low, high);
  }

  nlohmann::json SaveState() const override {
    nlohmann::json json;
    for (const LayerToggle& layer : kLayers) json[layer.name] = layers_.*layer.layer;
    return json;
  }
  void LoadState(const nlohmann::json& json) override {
    for (const LayerToggle& layer : kLayers)
      layers_.*layer.layer = json.value(layer.name, layers_.*layer.layer);
  }

 private:
  void DrawLayerToggles(const FrameContext& context, bool below_one_another) {
    for (const LayerToggle& layer : kLayers) {
      if (&layer != kLayers && !below_one_another) ImGui::SameLine();
      Toggle(context, fmt::format("scene.{}", layer.name), layer.label, layers_.*layer.layer,
             layer.tooltip);
    }
  }

  /// True while the view moves.
  bool HandleMouse(SceneSurface& scene, ImVec2 low, CommandSink& sink) {
    const ImGuiIO& io = ImGui::GetIO();
    const double x = io.MousePos.x - low.x, y = io.MousePos.y - low.y;
    const bool moving =
        ImGui::IsItemActive() &&
        (ImGui::IsMouseDragging(ImGuiMouseButton_Left, 1) ||
         ImGui::IsMouseDown(ImGuiMouseButton_Right) || ImGui::IsMouseDown(ImGuiMouseButton_Middle));
    const bool moved = io.MouseDelta.x != 0 || io.MouseDelta.y != 0;
    if (ImGui::IsItemActive() && moved) {
      const bool turns = ImGui::IsMouseDown(ImGuiMouseButton_Left) && !io.KeyShift && !io.KeyCtrl;
      turns ? scene.Orbit(io.MouseDelta.x, io.MouseDelta.y)
            : scene.Pan(io.MouseDelta.x, io.MouseDelta.y);
    }
    if (!ImGui::IsItemHovered()) return moving;
    if (io.MouseWheel != 0) scene.Zoom(io.MouseWheel);
    if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
      scene.FocusAt(x, y);
    } else if (ImGui::IsItemDeactivated() && ImGui::IsMouseReleased(ImGuiMouseButton_Left)) {
      const ImVec2 dragged = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0);
      if (dragged.x == 0 && dragged.y == 0) {
        if (const auto object = scene.Pick(x, y)) sink.Post(SelectObjectCommand{*object});
      }
    }
    return moving;
  }

  static void DrawTriad(const FrameContext& context, ImVec2 low, ImVec2 high) {
    const Eigen::Matrix3d view = context.scene->camera().view_from_world;
    const float length = context.Scaled(26);
    const ImVec2 origin(low.x + context.Scaled(40), high.y - context.Scaled(40));
    constexpr ImU32 kColors[] = {IM_COL32(236, 92, 88, 255), IM_COL32(112, 200, 100, 255),
                                 IM_COL32(92, 146, 246, 255)};
    constexpr const char* kNames[] = {"x", "y", "z"};
    int order[] = {0, 1, 2};
    std::sort(order, order + 3, [&](int a, int b) { return view(2, a) < view(2, b); });
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    for (const int axis : order) {
      const ImVec2 tip(origin.x + length * static_cast<float>(view(0, axis)),
                       origin.y - length * static_cast<float>(view(1, axis)));
      draw.AddLine(origin, tip, kColors[axis], context.Scaled(2));
      const ImVec2 at(origin.x + 1.35f * (tip.x - origin.x), origin.y + 1.35f * (tip.y - origin.y));
      const ImVec2 text =
          context.fonts.small->CalcTextSizeA(context.fonts.small->FontSize, 1e6f, 0, kNames[axis]);
      draw.AddText(context.fonts.small, context.fonts.small->FontSize,
                   {at.x - 0.5f * text.x, at.y - 0.5f * text.y}, kColors[axis], kNames[axis]);
    }
  }

  static void DrawGridLabel(const FrameContext& context, ImVec2 low, ImVec2 high) {
    PictureLabels labels(context, low, high);
    const std::string text = fmt::format("grid {:g} m", context.scene->grid_step_m());
    const float margin = context.Scaled(6);
    labels.Add({{high.x - labels.SizeOf(text).x - margin, high.y - margin}}, colors::kOnPictureDim,
               text);
  }

  SceneLayers layers_;
};

}  // namespace

std::unique_ptr<Panel> MakeScenePanel() { return std::make_unique<ScenePanel>(); }

}  // namespace plumbline
