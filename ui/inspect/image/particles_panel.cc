// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/particles_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/geometry/angle_text.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/common/waiting.h"
#include "ui/files/kept_value.h"
#include "ui/framework/image_canvas.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/image/overlays.h"

namespace plumbline {
namespace {

class ParticlesPanel : public Panel {
 public:
  void DrawHeader(const FrameContext& context, CommandSink&) override {
    AlignRight(ToggleWidth(context, "Close-up") + ToggleWidth(context, "Fronts") +
               context.Scaled(4));
    Toggle(context, "particles.closeup", "Close-up", closeup_,
           "Shows the surroundings of the object instead of the whole image.");
    ImGui::SameLine();
    Toggle(context, "particles.fronts", "Fronts", needles_,
           "A line along each hypothesis' front (+x).");
  }

  void Draw(const FrameContext& context, CommandSink& sink) override {
    if (DrawWaiting(context)) return;
    const ObjectReport* object = context.SelectedObject();
    if (object == nullptr) {
      return EmptyState(context, "No object selected",
                        "Click an object in the list, in an image or in the 3-D view.");
    }
    const MapSnapshot& snapshot = *context.snapshot;
    if (snapshot.image.empty())
      return EmptyState(context, "No image", "This frame came without an image.");
    const ImTextureID texture =
        context.textures->Get("image", context.snapshot_version, [&] { return snapshot.image; });
    const Box2 all{-0.5f, -0.5f, static_cast<float>(context.sequence->image_width) - 0.5f,
                   static_cast<float>(context.sequence->image_height) - 0.5f};
    const ImVec2 room = ImGui::GetContentRegionAvail();
    const Box2 part = closeup_ ? CloseUp(*object, all, room.x / std::max(1.0f, room.y)) : all;
    const ImageCanvas canvas(context, "particles.view", texture, context.sequence->image_width,
                             context.sequence->image_height, part);
    canvas.draw().AddRectFilled(canvas.low(), canvas.high(), IM_COL32(0, 0, 0, 110));
    DrawOutlineOverlay(context, canvas,
                       {.width_px = 1, .alpha = 0.7, .shadow = false, .only = object->id});
    const int nearest = DrawParticleOverlay(context, canvas, *object, {needles_, 1.75});
    DrawParticleOutline(context, canvas);
    PictureLabels(context, canvas.low(), canvas.high())
        .Add({{canvas.low().x, canvas.high().y}}, context.ColorOf(object->id),
             fmt::format("#{}  {} particles", object->id.value,
                         object->particles == nullptr ? 0 : object->particles->size()));
    if (nearest >= 0) sink.Post(HoverParticleCommand{nearest});
    if (nearest >= 0) DrawNumbers(context, *object->particles, nearest);
    if (canvas.clicked()) sink.Post(SelectParticleCommand{nearest});
  }

  nlohmann::json SaveState() const override {
    return {{"closeup", closeup_}, {"fronts", needles_}};
  }
  void LoadState(const nlohmann::json& json) override {
    closeup_ = KeptValue(json, "closeup", closeup_);
    needles_ = KeptValue(json, "fronts", needles_);
  }

 private:
  /// The box of the object with half as much again around it, in the shape of the panel, inside the
  /// image.
  static Box2 CloseUp(const ObjectReport& object, const Box2& all, float aspect) {
    if (object.whole_box.empty()) return all;
    float width = std::max(1.7f * object.whole_box.width(), 0.25f * all.width());
    float height = std::max(1.7f * object.whole_box.height(), 0.25f * all.height());
    width = std::max(width, height * aspect);
    width = std::min({width, all.width(), all.height() * aspect});
    height = width / aspect;
    const float x = std::clamp(object.whole_box.center_x() - 0.5f * width, all.x0, all.x1 - width);
    const float y =
        std::clamp(object.whole_box.center_y() - 0.5f * height, all.y0, all.y1 - height);
    return {x, y, x + width, y + height};
  }

  /// ", rank 3 of 500"; "" until it is known.
  static std::string RankOf(const FrameContext& context, int index) {
    const std::vector<int>* order = context.ParticlesByRank();
    if (order == nullptr) return "";
    const auto rank = std::find(order->begin(), order->end(), index) - order->begin();
    return fmt::format(", rank {} of {}", rank + 1, order->size());
  }

  static void DrawNumbers(const FrameContext& context, const std::vector<Particle>& particles,
                          int index) {
    const Particle& particle = particles[static_cast<std::size_t>(index)];
    const ModelView* model = context.Model({particle.label});
    PutTooltipBesideMouse(context);
    ImGui::BeginTooltip();
    ImGui::Text("Particle %d", index);
    DimText("model %s", model != nullptr ? model->name.c_str() : "?");
    DimText("weight %.4f%s", std::exp(particle.log_weight), RankOf(context, index).c_str());
    DimText("comes from particle %d of the frame before", int{particle.ancestor});
    DimText("distance %.2f m", std::exp(particle.rho));
    const bool round = model != nullptr && model->any_azimuth;
    DimText("%s", round ? "any azimuth" : ("azimuth " + AngleText(particle.azimuth)).c_str());
    DimText("\u03a6 detector %.2f   \u03a6 edges %.2f", particle.phi_cnn, particle.phi_edge);
    ImGui::EndTooltip();
  }

  bool closeup_ = true, needles_ = true;
};

}  // namespace

std::unique_ptr<Panel> MakeParticlesPanel() { return std::make_unique<ParticlesPanel>(); }

}  // namespace plumbline
