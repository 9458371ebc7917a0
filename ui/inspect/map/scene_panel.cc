// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/map/scene_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "ui/common/scene_mouse.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
#include "ui/framework/scene_surface.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/map/clip_box.h"
#include "ui/inspect/map/scene_overlay.h"

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
     "Mean states of the objects in their colours; tentative ones are the fainter, the less likely "
     "they are there."},
    {"particles", "Particles", &SceneLayers::particles,
     "Hypotheses of the selected object: centre and front."},
    {"scan", "Scan", &SceneLayers::scan,
     "Points of the scanned scene, where the sequence has one."},
    {"truth", "Truth", &SceneLayers::truth,
     "True places of the objects in green, where they are known."},
    {"smoothed", "Smoothed", &SceneLayers::smoothed,
     "Places of the objects as a second pass over the whole run has them, in violet."},
    {"trajectory", "Path", &SceneLayers::trajectory,
     "The camera's path; the part already walked is bright."},
    {"frustum", "Camera", &SceneLayers::frustum, "Where the camera is and what it sees."},
    {"grid", "Grid", &SceneLayers::grid, "Grid on the floor."},
};

/// A run without a second pass needs no switch for it.
bool Offered(const FrameContext& context, const LayerToggle& layer) {
  return layer.layer != &SceneLayers::smoothed ||
         (context.sequence != nullptr && context.sequence->smoothed != nullptr);
}

struct OverlayToggle {
  const char* name;
  const char* label;
  bool SceneOverlay::*part;
  const char* tooltip;
};
constexpr OverlayToggle kOverlays[] = {
    {"names", "Names", &SceneOverlay::names, "Numbers and models of confirmed objects."},
    {"spread", "Spread", &SceneOverlay::spread,
     "Ellipsoids that hold 95 % of the belief about each object's centre."},
    {"points", "Points", &SceneOverlay::points,
     "Points that the visual-inertial filter found up to this frame, in runs with own poses, where "
     "no confirmed object explains them."},
    {"links", "Links", &SceneOverlay::links,
     "Relations: green stands on, yellow hides from the camera, blue is nearest to."},
    {"parallel", "Parallel", &SceneOverlay::parallel,
     "Without perspective: equal lengths look equal, near and far. With the views from the axes (1 "
     "to 5), a plan and its elevations."},
    {"tape", "Tape", &SceneOverlay::tape,
     "Measures: click two points of models, scan or floor. A third begins anew; select in other "
     "panels meanwhile."},
};

constexpr const char* kClip = "Clip";

class ScenePanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink& sink) override {
    const float gap = context.Scaled(3), room = ImGui::GetContentRegionAvail().x;
    const float views =
        ToggleWidth(context, "Follow") + ToggleWidth(context, "Through") + context.Scaled(17);
    float layers = 0, overlays = ToggleWidth(context, ColorLabel().c_str()) +
                                 ToggleWidth(context, OpacityLabel().c_str()) +
                                 ToggleWidth(context, kClip) + 3 * gap;
    for (const LayerToggle& layer : kLayers) {
      if (Offered(context, layer)) layers += ToggleWidth(context, layer.label) + gap;
    }
    for (const OverlayToggle& part : kOverlays) overlays += ToggleWidth(context, part.label) + gap;
    const float more = ToggleWidth(context, "More") + gap;
    if (views + layers + overlays <= room) {
      AlignRight(views + layers + overlays);
      DrawLayerToggles(context, false);
      ImGui::SameLine();
      DrawOverlayToggles(context, false);
    } else if (views + layers + more <= room) {
      AlignRight(views + layers + more);
      DrawLayerToggles(context, false);
      ImGui::SameLine();
      DrawMenu(context, "More", false);
    } else {
      AlignRight(views + ToggleWidth(context, "Layers") + gap);
      DrawMenu(context, "Layers", true);
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
    KeepClipBox(context);
    SceneLayers layers = layers_;
    layers.truth_solid = coloring_ == SceneColoring::kOnTruth;
    layers.own_colors = coloring_ == SceneColoring::kOwn;
    context.scene->SetContent({context.sequence, context.snapshot, context.snapshot_version,
                               context.selection.object, context.selection.particle, layers,
                               context.follow, context.look_through, overlay_.parallel,
                               context.light, SceneObjectsOf(context, coloring_, opacity_),
                               context.ColorOf(context.selection.object), clip_.box});
    const ImVec2 low = ImGui::GetCursorScreenPos();
    const ImVec2 size = ImGui::GetContentRegionAvail();
    const int width = std::max(8, static_cast<int>(size.x)),
              height = std::max(8, static_cast<int>(size.y));
    ImGui::InvisibleButton("scene.view", {static_cast<float>(width), static_cast<float>(height)},
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight |
                               ImGuiButtonFlags_MouseButtonMiddle);
    LogItem(context, "scene.view");
    if (clip_.box) ImGui::SetItemAllowOverlap();
    const ImVec2 high(low.x + static_cast<float>(width), low.y + static_cast<float>(height));
    const bool moving = HandleMouse(context, low, high, sink);
    const bool playing = context.playback->state == PlaybackState::kPlaying;
    const ImTextureID texture = context.scene->Texture(width, height, moving || playing);
    ImGui::GetWindowDrawList()->AddImageRounded(texture, low, high, {0, 1}, {1, 0}, IM_COL32_WHITE,
                                                context.Scaled(4));
    DrawOverlay(context, low, high, sink);
    DrawTriad(context, context.scene->camera().view_from_world, low, high);
    if (layers_.grid && !context.look_through) DrawGridLabel(context, low, high);
    if (clip_.box) DrawClipButtons(context, low);
  }

  nlohmann::json SaveState() const override {
    nlohmann::json json;
    for (const OverlayToggle& toggle : kOverlays) json[toggle.name] = overlay_.*toggle.part;
    json["color"] = ColoringName(coloring_);
    json["opacity"] = opacity_;
    for (const LayerToggle& layer : kLayers) json[layer.name] = layers_.*layer.layer;
    if (kept_box_ && !clipped_source_.empty()) {
      json["clip"] = ToJson(*kept_box_);
      json["clip"]["on"] = clips_;
      json["clip"]["of"] = clipped_source_;
    }
    return json;
  }
  void LoadState(const nlohmann::json& json) override {
    for (const OverlayToggle& toggle : kOverlays)
      overlay_.*toggle.part = KeptValue(json, toggle.name, overlay_.*toggle.part);
    for (const auto coloring :
         {SceneColoring::kIdentity, SceneColoring::kOwn, SceneColoring::kState,
          SceneColoring::kError, SceneColoring::kOnTruth}) {
      if (KeptValue(json, "color", std::string(ColoringName(coloring_))) == ColoringName(coloring))
        coloring_ = coloring;
    }
    opacity_ = std::clamp(KeptValue(json, "opacity", opacity_), 0.1, 1.0);
    for (const LayerToggle& layer : kLayers)
      layers_.*layer.layer = KeptValue(json, layer.name, layers_.*layer.layer);
    if (const auto clip = json.find("clip"); clip != json.end()) {
      loaded_clip_ = *clip;
      clipped_version_.reset();
    }
  }

 private:
  void DrawMenu(const FrameContext& context, const char* label, bool layers_too) {
    bool open = false;
    if (Toggle(context, "scene.layers", label, open, "What the map shows."))
      ImGui::OpenPopup("layers");
    if (!ImGui::BeginPopup("layers")) return;
    if (layers_too) DrawLayerToggles(context, true);
    DrawOverlayToggles(context, true);
    ImGui::EndPopup();
  }

  void DrawLayerToggles(const FrameContext& context, bool below_one_another) {
    for (const LayerToggle& layer : kLayers) {
      if (!Offered(context, layer)) continue;
      if (&layer != kLayers && !below_one_another) ImGui::SameLine();
      Toggle(context, fmt::format("scene.{}", layer.name), layer.label, layers_.*layer.layer,
             layer.tooltip);
    }
  }

  void DrawOverlayToggles(const FrameContext& context, bool below_one_another) {
    for (const OverlayToggle& toggle : kOverlays) {
      if (&toggle != kOverlays && !below_one_another) ImGui::SameLine();
      Toggle(context, fmt::format("scene.{}", toggle.name), toggle.label, overlay_.*toggle.part,
             toggle.tooltip);
    }
    if (!below_one_another) ImGui::SameLine();
    bool other = coloring_ != SceneColoring::kIdentity;
    if (Toggle(context, "scene.color", ColorLabel().c_str(), other,
               "What the colours of the models mean: which object it is, the models' own (those "
               "without stay as they are), its state, or its error "
               "against ground truth (green 0, red 10 cm or more, grey unknown); or green "
               "estimates on "
               "the truth in grey. A click goes to the next."))
      coloring_ = static_cast<SceneColoring>((static_cast<int>(coloring_) + 1) % 5);
    if (!below_one_another) ImGui::SameLine();
    bool thin = opacity_ < 1;
    if (Toggle(context, "scene.opacity", OpacityLabel().c_str(), thin,
               "How solid the models are. A click goes to the next: 100, 60, 30 %. Tentative ones "
               "are fainter, the less likely they are there."))
      opacity_ = opacity_ > 0.9 ? 0.6 : opacity_ > 0.5 ? 0.3 : 1.0;
    if (!below_one_another) ImGui::SameLine();
    Toggle(context, "scene.clip", kClip, clips_,
           "Cuts the map by a box: drag its sides by their dots. What lies outside is not drawn.");
  }

  /// The box belongs to what is open, and comes back with it.
  void KeepClipBox(const FrameContext& context) {
    if (clipped_version_ != context.source_version) {
      clipped_version_ = context.source_version;
      clipped_source_ = context.source;
      clips_ = false;
      kept_box_.reset();
      clip_.box.reset();
      if (!clipped_source_.empty() && loaded_clip_.is_object() &&
          loaded_clip_.value("of", nlohmann::json()) == clipped_source_) {
        kept_box_ = ClipBoxFromJson(loaded_clip_);
        clips_ = kept_box_ && loaded_clip_.value("on", nlohmann::json()) == true;
      }
    }
    if (clip_.box) kept_box_ = clip_.box;
    if (!clips_ || context.look_through) {
      clip_.box.reset();
    } else if (!clip_.box) {
      clip_.box = kept_box_ ? kept_box_ : WholeBox(context);
    }
  }

  static std::optional<ClipBox> WholeBox(const FrameContext& context) {
    const Eigen::AlignedBox3d bounds = context.scene->bounds_in_world();
    if (bounds.isEmpty()) return std::nullopt;
    return ClipAround(bounds, context.sequence->up_in_world);
  }

  void DrawClipButtons(const FrameContext& context, ImVec2 low) {
    const ImVec2 before = ImGui::GetCursorScreenPos();
    const float gap = context.Scaled(4);
    ImGui::SetCursorScreenPos({low.x + gap, low.y + gap});
    bool whole = true;
    if (Toggle(context, "scene.clip.whole", "All", whole, "The box around everything."))
      clip_.box = WholeBox(context);
    if (const ObjectReport* object = context.SelectedObject()) {
      ImGui::SameLine(0, gap);
      bool around = true;
      if (Toggle(context, "scene.clip.object", "Around the selected", around,
                 "The box around the selected object, with half a metre of what is beside it.")) {
        if (const auto box = ClipAroundObject(context, *object)) clip_.box = box;
      }
    }
    ImGui::SetCursorScreenPos(before);
  }

  std::string OpacityLabel() const { return fmt::format("Solid: {:.0f} %", 100 * opacity_); }
  std::string ColorLabel() const { return fmt::format("Colour: {}", ColoringName(coloring_)); }

  void DrawOverlay(const FrameContext& context, ImVec2 low, ImVec2 high, CommandSink& sink) {
    if (context.snapshot == nullptr) return;
    if (overlay_.links) sink.Post(NeedCommand{NeedCommand::What::kRelations});
    if (context.analysis != nullptr && context.analysis->relations)
      relations_ = *context.analysis->relations;
    const SceneProjection project(context, context.scene->camera(), low, high);
    SceneOverlay overlay = overlay_;
    overlay.truth_names = overlay.names && layers_.truth;
    overlay.clip = clip_.box;
    DrawSceneOverlay(context, project, low, high, overlay, relations_);
    clip_.Draw(context, project, low, high);
    if (!overlay_.tape) tape_ = {};
    if (overlay_.tape) DrawTape(context, project, low, high, tape_);
  }

  /// True while the view moves.
  bool HandleMouse(const FrameContext& context, ImVec2 low, ImVec2 high, CommandSink& sink) {
    SceneSurface& scene = *context.scene;
    const bool held = clip_.box && context.snapshot != nullptr &&
                      clip_.Handle(context, SceneProjection(context, scene.camera(), low, high));
    const bool moving = MoveView(scene, low, held);
    if (held) return true;
    const auto clicked = ClickedAt();
    if (!clicked || ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) return moving;
    if (overlay_.tape) {
      if (const auto point = scene.PointAt(clicked->x - low.x, clicked->y - low.y))
        tape_.Add(*point);
      return moving;
    }
    std::string truth;
    if (layers_.truth && context.snapshot != nullptr)
      truth = TruthNear(context, SceneProjection(context, scene.camera(), low, high), *clicked);
    if (const auto object = scene.Pick(clicked->x - low.x, clicked->y - low.y))
      sink.Post(SelectObjectCommand{*object});
    else if (!truth.empty())
      sink.Post(SelectTruthCommand{truth});
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
  SceneOverlay overlay_;
  Tape tape_;
  SceneColoring coloring_ = SceneColoring::kIdentity;
  double opacity_ = 1;
  bool clips_ = false;
  ClipHandles clip_;
  std::optional<ClipBox> kept_box_;               ///< As it was when it was switched off.
  std::optional<std::uint64_t> clipped_version_;  ///< Of the source that it is the box of.
  std::string clipped_source_;
  nlohmann::json loaded_clip_;             ///< From the settings, maybe of something else.
  std::vector<ObjectRelation> relations_;  ///< The newest that are known.
};

}  // namespace

ActionGroup MapActions() {
  return {"Map",
          {{.text = "Map: look through the camera",
            .keys = {{'0'}},
            .run = [](const FrameContext& context,
                      CommandSink& sink) { sink.Post(LookThroughCommand{!context.look_through}); },
            .help_keys = "0",
            .help = "Map through the camera",
            .text_when_on = "Map: leave the camera",
            .is_on = [](const FrameContext& context) { return context.look_through; }},
           {.text = "Map: follow the camera",
            .run = [](const FrameContext& context,
                      CommandSink& sink) { sink.Post(FollowCommand{!context.follow}); },
            .text_when_on = "Map: do not follow the camera",
            .is_on = [](const FrameContext& context) { return context.follow; }}}};
}

std::unique_ptr<Panel> MakeScenePanel() { return std::make_unique<ScenePanel>(); }

}  // namespace plumbline
