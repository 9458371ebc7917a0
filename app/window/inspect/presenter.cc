// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/presenter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "ui/framework/layout.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kShot_s = 8, kFade_s = 0.5;
constexpr double kTurn_radps = 0.12;
constexpr double kElevation_rad = 0.62;

struct Place {
  const char* panel;
  float x0, y0, x1, y1;
};

struct Shot {
  const char* title;
  const char* caption;
  std::vector<Place> places;
  nlohmann::json states;  ///< Of panels, for this view.
  bool through = false, follow = false, needs_truth = false;
};

const std::vector<Shot>& Shots() {
  using nlohmann::json;
  const json plain_image = {{"proposals", false}, {"weak", false},      {"outlines", false},
                            {"names", false},     {"particles", false}, {"contour", false}};
  const json map = {{"models", true}, {"particles", false}, {"scan", true},
                    {"truth", false}, {"trajectory", true}, {"frustum", true},
                    {"grid", true},   {"names", true},      {"spread", false},
                    {"links", false}, {"color", "identity"}};
  const auto with = [](json base, const json& more) {
    base.update(more);
    return base;
  };
  static const std::vector<Shot> kShots = {
      {"A camera walks through a room",
       "One colour camera and its path. From these pictures alone Plumbline finds the objects.",
       {{"image", 0, 0, 1, 1}},
       {{"image", plain_image}}},
      {"A detector proposes",
       "Boxes say what may be where in one picture. They come and go; many are wrong.",
       {{"image", 0, 0, 1, 1}},
       {{"image", with(plain_image, {{"proposals", true}})}}},
      {"Edges say where surfaces end",
       "Their direction is the colour, their probability the brightness. They tell poses apart.",
       {{"image", 0, 0, 0.5f, 1}, {"edges", 0.5f, 0, 1, 1}},
       {{"image", with(plain_image, {{"outlines", true}})},
        {"edges", {{"outlines", true}, {"contour", false}, {"difference", false}}}}},
      {"An object is a cloud of hypotheses",
       "Each line is one guess of place, direction and shape. Those that fit the pictures survive.",
       {{"particles", 0, 0, 0.5f, 1}, {"scene", 0.5f, 0, 1, 1}},
       {{"scene", with(map, {{"particles", true}, {"scan", false}})}}},
      {"What is believed, drawn back into the picture",
       "Models at their mean states: outlines, and the visible parts, darker where they are "
       "closer.",
       {{"image", 0, 0, 0.5f, 1}, {"masks", 0.5f, 0, 1, 1}},
       {{"image", with(plain_image, {{"outlines", true}, {"names", true}})}}},
      {"The map",
       "Whole objects with names, sizes and directions, also where the camera no longer looks.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", map}}},
      {"What the map does not know it says",
       "Ellipsoids hold 95 % of the belief about each place.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", with(map, {{"spread", true}, {"names", false}})}}},
      {"How things stand to one another",
       "Green: stands on. Yellow: hides from the camera. Blue: is nearest to.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", with(map, {{"links", true}})}}},
      {"Through the camera",
       "The models over the picture they were found in.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", with(map, {{"scan", false}, {"frustum", false}, {"trajectory", false}})}},
       true},
      {"Against the truth",
       "Green models are where the true ones are, red ones 10 cm off or more.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", with(map, {{"color", "error"}, {"truth", true}})}},
       false,
       false,
       true},
  };
  return kShots;
}

double Seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

void Presenter::Start(FrameContext& context, std::span<Panel* const> panels, CommandSink& sink) {
  if (active_) return;
  active_ = true;
  armed_ = false;
  for (Panel* panel : panels) panel_states_[panel->Id()] = panel->SaveState();
  look_through_ = context.look_through;
  follow_ = context.follow;
  loop_ = context.playback->loop;
  played_ = context.playback->state == PlaybackState::kPlaying;
  if (context.scene != nullptr) camera_ = context.scene->camera();
  context.presenting = true;
  sink.Post(SetLoopCommand{true});
  sink.Post(PlayCommand{});
  Enter(0, context, panels);
}

void Presenter::Stop(FrameContext& context, std::span<Panel* const> panels, CommandSink& sink) {
  if (!active_) return;
  active_ = false;
  context.presenting = false;
  context.look_through = look_through_;
  context.follow = follow_;
  for (Panel* panel : panels) panel->LoadState(panel_states_[panel->Id()]);
  if (context.scene != nullptr)
    context.scene->SetDirection(camera_.azimuth_rad, camera_.elevation_rad);
  sink.Post(SetLoopCommand{loop_});
  if (!played_) sink.Post(PauseCommand{});
}

void Presenter::Enter(std::size_t shot, FrameContext& context, std::span<Panel* const> panels) {
  shot_ = shot % Shots().size();
  const bool truth = context.sequence != nullptr && !context.sequence->truth.empty();
  if (Shots()[shot_].needs_truth && !truth) shot_ = 0;
  entered_ = Clock::now();
  const Shot& now = Shots()[shot_];
  context.look_through = now.through;
  context.follow = now.follow;
  for (Panel* panel : panels) {
    if (now.states.contains(panel->Id())) panel->LoadState(now.states.at(panel->Id()));
  }
}

bool Presenter::Touched() {
  const ImGuiIO& io = ImGui::GetIO();
  const bool key =
      std::any_of(std::begin(io.KeysDown), std::end(io.KeysDown), [](bool down) { return down; });
  const bool button =
      std::any_of(std::begin(io.MouseDown), std::end(io.MouseDown), [](bool down) { return down; });
  if (!key && !button) armed_ = true;
  return armed_ && (key || button);
}

bool Presenter::Draw(FrameContext& context, ImVec2 size, std::span<Panel* const> panels,
                     CommandSink& sink) {
  if (Seconds(Clock::now() - entered_) > kShot_s) Enter(shot_ + 1, context, panels);
  const Shot& now = Shots()[shot_];
  if (context.scene != nullptr && !now.through && !now.follow) {
    const double t = Seconds(Clock::now().time_since_epoch());
    context.scene->SetDirection(std::fmod(kTurn_radps * t, 6.283185307),
                                kElevation_rad + 0.12 * std::sin(0.3 * t));
  }
  FrameContext bare = context;
  bare.bare = true;
  const float band = context.Scaled(96), gap = context.Scaled(6);
  const float height = size.y - band;
  for (const Place& place : now.places) {
    const LayoutRect rect{{place.x0 * size.x + gap, place.y0 * height + gap},
                          {place.x1 * size.x - gap, place.y1 * height - gap}};
    for (Panel* panel : panels) {
      if (std::string(panel->Id()) == place.panel) DrawPanel(bare, rect, *panel, sink);
    }
  }
  DrawCaption(context, {0, height}, size);
  return Touched();
}

void Presenter::DrawCaption(const FrameContext& context, ImVec2 low, ImVec2 high) const {
  const Shot& now = Shots()[shot_];
  const double age = Seconds(Clock::now() - entered_);
  const double alpha = std::clamp(std::min(age, kShot_s - age) / kFade_s, 0.0, 1.0);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const ImFont* title = context.fonts.title;
  const float x = low.x + context.Scaled(28), y = low.y + context.Scaled(12);
  draw.AddText(title, title->FontSize, {x, y}, WithAlpha(colors::kText, alpha), now.title);
  const ImFont* text = context.fonts.text;
  draw.AddText(text, 1.15f * text->FontSize, {x, y + 1.35f * title->FontSize},
               WithAlpha(colors::kDimText, alpha), now.caption);
  const ImFont* small = context.fonts.small;
  constexpr const char* kEnds = "any key ends the demo";
  const float width = small->CalcTextSizeA(small->FontSize, 1e6f, 0, kEnds).x;
  draw.AddText(small, small->FontSize,
               {high.x - width - context.Scaled(20), high.y - 1.8f * small->FontSize},
               colors::kFaint, kEnds);
  const auto shots = static_cast<float>(Shots().size());
  const float done = (static_cast<float>(shot_) + static_cast<float>(age / kShot_s)) / shots;
  draw.AddRectFilled({low.x, high.y - context.Scaled(2)}, {low.x + done * (high.x - low.x), high.y},
                     colors::kAccentDim);
}

}  // namespace plumbline
