// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/presenter.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "engine/snapshot/map_snapshot.h"
#include "ui/framework/layout.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kShot_s = 8, kFade_s = 0.5;
constexpr double kSeek_s = 0.5;  ///< Until a frame that was sought may be sought again.
constexpr double kTurn_radps = 0.12;
constexpr double kElevation_rad = 0.62;
constexpr float kBandShare = 0.14f;  ///< Of the window's height, for captions.

struct Place {
  const char* panel;
  float x0, y0, x1, y1;
};

struct Shot {
  const char* title;
  const char* caption;
  std::vector<Place> places;
  nlohmann::json states;  ///< Of panels, for this view.
  /// What it would be empty without.
  enum class Needs { kImage, kEdges, kParticles, kObjects, kTwoObjects, kImageAndPose, kTruth };
  Needs needs = Needs::kImage;
  bool through = false;
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
        {"edges", {{"outlines", true}, {"contour", false}, {"difference", false}}}},
       Shot::Needs::kEdges},
      {"An object is a cloud of hypotheses",
       "Each line is one guess of place, direction and shape. Those that fit the pictures survive.",
       {{"particles", 0, 0, 0.5f, 1}, {"scene", 0.5f, 0, 1, 1}},
       {{"scene", with(map, {{"particles", true}, {"scan", false}})}},
       Shot::Needs::kParticles},
      {"What is believed, drawn back into the picture",
       "Models at their mean states: outlines, and the visible parts, darker where they are "
       "closer.",
       {{"image", 0, 0, 0.5f, 1}, {"masks", 0.5f, 0, 1, 1}},
       {{"image", with(plain_image, {{"outlines", true}, {"names", true}})}},
       Shot::Needs::kObjects},
      {"The map",
       "Whole objects with names, sizes and directions, also where the camera no longer looks.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", map}},
       Shot::Needs::kObjects},
      {"What the map does not know it says",
       "Ellipsoids hold 95 % of the belief about each place.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", with(map, {{"spread", true}, {"names", false}})}},
       Shot::Needs::kObjects},
      {"How things stand to one another",
       "Green: stands on. Yellow: hides from the camera. Blue: is nearest to.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", with(map, {{"links", true}})}},
       Shot::Needs::kTwoObjects},
      {"Through the camera",
       "The models over the picture they were found in.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", with(map, {{"scan", false}, {"frustum", false}, {"trajectory", false}})}},
       Shot::Needs::kImageAndPose,
       true},
      {"Against the truth",
       "Green models are where the true ones are, red ones 10 cm off or more.",
       {{"scene", 0, 0, 1, 1}},
       {{"scene", with(map, {{"color", "error"}, {"truth", true}})}},
       Shot::Needs::kTruth},
  };
  return kShots;
}

bool HasParticles(const ObjectReport* object) {
  return object != nullptr && object->particles != nullptr && !object->particles->empty() &&
         object->updated;
}

/// Whether a view has something to show in the frame that shows.
bool Offers(const FrameContext& context, Shot::Needs needs) {
  if (context.sequence == nullptr || context.snapshot == nullptr) return false;
  const MapSnapshot& snapshot = *context.snapshot;
  const auto& objects = snapshot.report.objects;
  const auto confirmed = std::count_if(objects.begin(), objects.end(), [](const auto& object) {
    return object.state == ObjectState::kConfirmed;
  });
  const bool image = !snapshot.image.empty();
  switch (needs) {
    case Shot::Needs::kImage:
      return image;
    case Shot::Needs::kEdges:
      return image && !snapshot.edge_probability.empty();
    case Shot::Needs::kParticles:
      return image && std::any_of(objects.begin(), objects.end(),
                                  [](const auto& object) { return HasParticles(&object); });
    case Shot::Needs::kObjects:
      return confirmed > 0;
    case Shot::Needs::kTwoObjects:
      return confirmed > 1;
    case Shot::Needs::kImageAndPose:
      return image && confirmed > 0 && snapshot.report.world_from_cam.has_value();
    case Shot::Needs::kTruth:
      return confirmed > 0 && !context.sequence->truth.empty();
  }
  return false;
}

/// A frame of what is known of the run in which a view would have something to show; nothing: none.
std::optional<int> FrameFor(const FrameContext& context, Shot::Needs needs) {
  const int least = needs == Shot::Needs::kTwoObjects                                       ? 2
                    : needs == Shot::Needs::kObjects || needs == Shot::Needs::kImageAndPose ? 1
                    : needs == Shot::Needs::kTruth && context.sequence != nullptr &&
                            !context.sequence->truth.empty()
                        ? 1
                        : 0;
  if (least == 0 && needs != Shot::Needs::kParticles) return std::nullopt;
  for (const auto& frame : context.shown_playback().history->frames) {
    if (frame == nullptr || frame->skipped) continue;
    const auto count = std::count_if(
        frame->objects.begin(), frame->objects.end(), [&](const ObjectSample& object) {
          return least > 0 ? object.state == ObjectState::kConfirmed : object.updated;
        });
    if (count >= std::max(1, least)) return frame->frame;
  }
  return std::nullopt;
}

double Seconds(std::chrono::steady_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

void Presenter::Start(FrameContext& context, std::span<Panel* const> panels, CommandSink& sink) {
  if (active_) return;
  active_ = true;
  armed_ = false;
  for (Panel* panel : panels) panel_states_[panel->id()] = panel->SaveState();
  look_through_ = context.look_through;
  follow_ = context.follow;
  loop_ = context.playback->loop;
  played_ = context.playback->state == PlaybackState::kPlaying;
  mapped_on_ = context.playback->mapping && context.playback->follow;
  frame_ = context.playback->frame;
  selection_ = context.selection;
  if (context.viewport != nullptr) viewport_ = std::exchange(*context.viewport, {});
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
  context.selection = selection_;
  if (context.viewport != nullptr) *context.viewport = viewport_;
  for (Panel* panel : panels) panel->LoadState(panel_states_[panel->id()]);
  if (context.scene != nullptr) context.scene->SetCamera(camera_);
  sink.Post(SetLoopCommand{loop_});
  if (mapped_on_) {
    sink.Post(FollowNewestCommand{});
    return;
  }
  sink.Post(PauseCommand{});
  sink.Post(SeekCommand{frame_});
  if (played_) sink.Post(PlayCommand{});
}

void Presenter::SelectOneWithParticles(FrameContext& context) const {
  if (HasParticles(context.SelectedObject())) return;
  for (const ObjectReport& object : context.snapshot->report.objects) {
    if (!HasParticles(&object)) continue;
    context.selection = {};
    context.selection.object = object.id;
    if (object.state == ObjectState::kConfirmed) return;
  }
}

void Presenter::Enter(std::size_t shot, FrameContext& context, std::span<Panel* const> panels) {
  const std::size_t count = Shots().size();
  shot_ = shot % count;
  const auto has_something = [&](Shot::Needs needs) {
    return Offers(context, needs) || FrameFor(context, needs);
  };
  for (std::size_t i = 0; i < count && !has_something(Shots()[shot_].needs); ++i)
    shot_ = (shot_ + 1) % count;
  entered_ = Clock::now();
  const Shot& now = Shots()[shot_];
  context.look_through = now.through;
  context.follow = false;
  for (Panel* panel : panels) {
    if (now.states.contains(panel->id())) panel->LoadState(now.states.at(panel->id()));
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

void Presenter::LeaveEmptiness(FrameContext& context, std::span<Panel* const> panels,
                               CommandSink& sink) {
  const auto frame = FrameFor(context, Shots()[shot_].needs);
  if (!frame) {
    const bool any = std::any_of(Shots().begin(), Shots().end(),
                                 [&](const Shot& shot) { return Offers(context, shot.needs); });
    if (any) Enter(shot_ + 1, context, panels);
    return;
  }
  if (Seconds(Clock::now() - sought_) < kSeek_s) return;
  sought_ = Clock::now();
  sink.Post(SeekCommand{*frame});
  sink.Post(PlayCommand{});
}

bool Presenter::Draw(FrameContext& context, ImVec2 size, std::span<Panel* const> panels,
                     CommandSink& sink) {
  if (Seconds(Clock::now() - entered_) > kShot_s) Enter(shot_ + 1, context, panels);
  if (!Offers(context, Shots()[shot_].needs)) LeaveEmptiness(context, panels, sink);
  const Shot& now = Shots()[shot_];
  if (now.needs == Shot::Needs::kParticles && context.snapshot != nullptr)
    SelectOneWithParticles(context);
  if (context.scene != nullptr && !now.through) {
    const double t = Seconds(Clock::now().time_since_epoch());
    context.scene->SetDirection(std::fmod(kTurn_radps * t, 6.283185307),
                                kElevation_rad + 0.12 * std::sin(0.3 * t));
  }
  FrameContext bare = context;
  bare.bare = true;
  const float gap = context.Scaled(6);
  const float height = size.y - kBandShare * size.y;
  for (const Place& place : now.places) {
    const LayoutRect rect{{place.x0 * size.x + gap, place.y0 * height + gap},
                          {place.x1 * size.x - gap, place.y1 * height - gap}};
    for (Panel* panel : panels) {
      if (std::string(panel->id()) == place.panel) DrawPanel(bare, rect, *panel, sink);
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
  const ImFont* font = context.fonts.caption;
  const float band = high.y - low.y, x = low.x + 0.2f * band, room = high.x - low.x - 0.4f * band;
  // As large as the band has room for, and as the window is wide.
  const auto line = [&](const char* text, float share, float top, ImU32 color) {
    const float wanted = share * band;
    const float width = font->CalcTextSizeA(wanted, 1e6f, 0, text).x;
    const float size = width > room ? wanted * room / width : wanted;
    draw.AddText(font, size, {x, low.y + top * band}, WithAlpha(color, alpha), text);
  };
  line(now.title, 0.38f, 0.08f, colors::kText);
  line(now.caption, 0.24f, 0.52f, colors::kDimText);
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
