// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/framework/scene_surface.h"
#include "ui/framework/widgets.h"
#include "ui/panels/panels.h"
#include "ui/panels/scene_mouse.h"
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
    DrawTriad(context, context.scene->camera().view_from_world, low, high);
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
    const bool moving = MoveView(scene, low, false);
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    if (WasClicked() && !ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) {
      if (const auto object = scene.Pick(mouse.x - low.x, mouse.y - low.y))
        sink.Post(SelectObjectCommand{*object});
    }
    return moving;
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
