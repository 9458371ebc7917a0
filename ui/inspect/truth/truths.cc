// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/truth/truths.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/snapshot/map_snapshot.h"
#include "ui/framework/widgets.h"
#include "ui/inspect/image/overlays.h"

namespace plumbline {
namespace {

/// Of corners in order, closed.
void DashedRectangle(ImDrawList& draw, ImVec2 low, ImVec2 high, ImU32 color, float width,
                     float dash) {
  const auto line = [&](ImVec2 from, ImVec2 to) {
    const float length = std::hypot(to.x - from.x, to.y - from.y);
    const ImVec2 along((to.x - from.x) / length, (to.y - from.y) / length);
    for (float at = 0; at < length; at += 2 * dash) {
      const float end = std::min(length, at + dash);
      draw.AddLine({from.x + at * along.x, from.y + at * along.y},
                   {from.x + end * along.x, from.y + end * along.y}, color, width);
    }
  };
  if (high.x - low.x < 1 || high.y - low.y < 1) return;
  line(low, {high.x, low.y});
  line({high.x, low.y}, high);
  line(high, {low.x, high.y});
  line({low.x, high.y}, low);
}

/// The outline of the selected instance, once the probe has answered for this frame.
bool DrawSelectedOutline(const FrameContext& context, const ImageCanvas& canvas) {
  const ProbeView* probe = ProbeOfSelection(context);
  if (probe == nullptr || probe->truth.empty() || probe->hypotheses.empty()) return false;
  std::vector<ImVec2> points;
  for (const auto& contour : probe->hypotheses.front().outline) {
    points.clear();
    for (const Eigen::Vector2f& p : contour) points.push_back(canvas.ToScreen(p));
    const int count = static_cast<int>(points.size());
    canvas.draw().AddPolyline(points.data(), count, IM_COL32(0, 0, 0, 140), ImDrawFlags_Closed,
                              context.Scaled(4));
    canvas.draw().AddPolyline(points.data(), count, colors::kTruth, ImDrawFlags_Closed,
                              context.Scaled(2.2));
  }
  return !probe->hypotheses.front().outline.empty();
}

/// A true instance in the image that shows.
struct ShownTruth {
  const TruthView& truth;
  const TruthSample& sample;
  bool selected = false;
  bool there = false;  ///< In the map, confirmed.
  ImVec2 low, high;    ///< On the screen.
  ImU32 color = 0;
};

template <typename Draw>
void ForEachShown(const FrameContext& context, const ImageCanvas& canvas, bool all,
                  const Draw& draw) {
  const FrameSample* sample = ShownSample(context);
  if (sample == nullptr || context.truths == nullptr) return;
  const auto& truths = context.truths->truths;
  for (std::size_t i = 0; i < std::min(truths.size(), sample->truths.size()); ++i) {
    const TruthSample& truth = sample->truths[i];
    const bool selected = truths[i].id == context.selection.truth;
    if (truth.box.empty() || (!all && !selected)) continue;
    const bool there = truth.object.value > 0 && truth.confirmed;
    draw(ShownTruth{truths[i], truth, selected, there, canvas.ToScreen(truth.box.x0, truth.box.y0),
                    canvas.ToScreen(truth.box.x1, truth.box.y1),
                    WithAlpha(colors::kTruth, selected || !there ? 1.0 : 0.6)});
  }
}

}  // namespace

const FrameSample* ShownSample(const FrameContext& context) {
  if (context.snapshot == nullptr) return nullptr;
  const auto& frames = context.shown_playback().history->frames;
  const int frame = context.snapshot->report.frame;
  // Most runs take every frame.
  const auto at = static_cast<std::size_t>(frame);
  if (at < frames.size() && frames[at] != nullptr && frames[at]->frame == frame)
    return frames[at].get();
  for (const auto& sample : frames) {
    if (sample != nullptr && sample->frame == frame) return sample.get();
  }
  return nullptr;
}

const TruthView* SelectedTruth(const FrameContext& context) {
  if (context.truths == nullptr || context.selection.truth.empty()) return nullptr;
  for (const TruthView& truth : context.truths->truths) {
    if (truth.id == context.selection.truth) return &truth;
  }
  return nullptr;
}

std::string TruthInWords(const TruthView& truth, const TruthSample& sample) {
  std::string text =
      truth.id + (sample.visible_px > 0 ? fmt::format(": {:.0f} px of it show", sample.visible_px)
                                        : std::string(": out of sight"));
  if (sample.box_fate) {
    text += fmt::format(", a box over it: {}", InWords(NameOf(*sample.box_fate)));
    if (sample.box_object.value > 0) text += fmt::format(" (object #{})", sample.box_object.value);
  }
  if (sample.object.value > 0) {
    text += fmt::format(", it is #{}{}", sample.object.value,
                        sample.confirmed ? "" : ", not confirmed yet");
  } else if (!sample.near.empty()) {
    text += fmt::format(", nearest is #{}, {:.0f} cm away", sample.near.front().object.value,
                        100 * sample.near.front().distance_m);
  }
  return text;
}

void DrawTruthOverlay(const FrameContext& context, const ImageCanvas& canvas, bool all) {
  const bool outlined = DrawSelectedOutline(context, canvas);
  ForEachShown(context, canvas, all, [&](const ShownTruth& shown) {
    context.widgets->Add("image.truth." + shown.truth.id, shown.low, shown.high);
    const float width = context.Scaled(shown.selected ? 2 : 1.25);
    if (shown.there)
      canvas.draw().AddRect(shown.low, shown.high, shown.color, 0, 0, width);
    else if (!(shown.selected && outlined))
      DashedRectangle(canvas.draw(), shown.low, shown.high, shown.color, width, context.Scaled(5));
  });
}

void LabelTruths(const FrameContext& context, const ImageCanvas& canvas, bool all,
                 PictureLabels& labels) {
  ForEachShown(context, canvas, all, [&](const ShownTruth& shown) {
    const ImVec2 low = shown.low, high = shown.high;
    const ImVec2 size = labels.SizeOf(shown.truth.id);
    labels.Add({{high.x - size.x, high.y},
                {low.x, high.y},
                {high.x - size.x, low.y + size.y},
                {high.x - size.x, high.y - 1.15f * size.y},
                {low.x, low.y + size.y}},
               shown.color, shown.truth.id);
    if (!canvas.hovered() || !ImGui::IsMouseHoveringRect({high.x - size.x, high.y - size.y}, high))
      return;
    PutTooltipBeside(context, low, high);
    ImGui::SetTooltip("%s", TruthInWords(shown.truth, shown.sample).c_str());
  });
}

std::string TruthAt(const FrameContext& context, const Eigen::Vector2f& pixel) {
  const FrameSample* sample = ShownSample(context);
  if (sample == nullptr || context.truths == nullptr) return "";
  std::string found;
  float smallest = 0;
  const auto& truths = context.truths->truths;
  for (std::size_t i = 0; i < std::min(truths.size(), sample->truths.size()); ++i) {
    const Box2& box = sample->truths[i].box;
    const bool inside = !box.empty() && pixel.x() >= box.x0 && pixel.x() <= box.x1 &&
                        pixel.y() >= box.y0 && pixel.y() <= box.y1;
    if (!inside || (!found.empty() && box.area() >= smallest)) continue;
    found = truths[i].id;
    smallest = box.area();
  }
  return found;
}

}  // namespace plumbline
