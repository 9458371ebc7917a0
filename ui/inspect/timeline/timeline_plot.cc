// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/timeline/timeline_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

constexpr const char* kNeedsTruth = "needs ground truth: no object is within 1 m of a true one";

using Sample = ObjectSample;

constexpr PlottedQuantity kQuantities[] = {
    {"position", "Position spread", "cm", "Standard deviation of the position over all modes.",
     [](const Sample& s) -> std::optional<float> { return 100 * s.position_std_m; }, ""},
    {"azimuth", "Azimuth spread", "\u00b0",
     "Standard deviation of the azimuth over all modes; round shapes have none.",
     [](const Sample& s) -> std::optional<float> {
       return s.round ? std::nullopt : std::optional<float>(kDegPerRad * s.azimuth_std_rad);
     },
     "all shapes are round"},
    {"error", "Error of position", "cm",
     "Distance of the mean from the nearest true object of its category.",
     [](const Sample& s) -> std::optional<float> {
       return s.error ? std::optional(100 * s.error->translation_m) : std::nullopt;
     },
     kNeedsTruth},
    {"turned", "Error of azimuth", "\u00b0",
     "Angle from the nearest true object of its category, modulo its symmetry.",
     [](const Sample& s) -> std::optional<float> {
       return s.error && !s.round ? std::optional<float>(kDegPerRad * s.error->azimuth_rad)
                                  : std::nullopt;
     },
     kNeedsTruth},
    {"cnn", "\u03a6 detector", "", "Detector term of the score at the mean.",
     [](const Sample& s) { return s.updated ? std::optional(s.phi_cnn) : std::nullopt; },
     "no object was updated"},
    {"edge", "\u03a6 edges", "", "Edge term of the score at the mean.",
     [](const Sample& s) { return s.updated ? std::optional(s.phi_edge) : std::nullopt; },
     "no object was updated"},
    {"evidence", "Evidence", "log odds", "Log odds that the object exists.",
     [](const Sample& s) -> std::optional<float> { return s.log_evidence; }, ""},
    {"ess", "Sample size", "particles", "Effective number of particles.",
     [](const Sample& s) -> std::optional<float> { return s.effective_sample_size; }, ""},
    {"label", "Label probability", "%", "Probability of the most likely shape.",
     [](const Sample& s) -> std::optional<float> {
       return s.label_probability.empty()
                  ? std::nullopt
                  : std::optional(100 * static_cast<float>(s.label_probability[0].probability));
     },
     ""},
    {"visible", "Visible", "%", "Share of the contour that shows.",
     [](const Sample& s) -> std::optional<float> { return 100 * s.visible_fraction; }, ""},
};

/// The values of an object at the columns of the screen: of several frames in one, the extremes.
struct Curve {
  std::vector<ImVec2> points;  ///< x on the screen, y in the unit.
  bool confirmed = false;
};

std::map<ObjectId, Curve> CurvesOf(const FrameContext& context, const TimeAxis& axis,
                                   const PlottedQuantity& quantity) {
  std::map<ObjectId, Curve> curves;
  for (const auto& sample : context.shown_playback().history->frames) {
    if (sample == nullptr || sample->frame < axis.first - 1 || sample->frame > axis.last + 1)
      continue;
    const float x = axis.XOf(sample->frame);
    for (const ObjectSample& object : sample->objects) {
      const auto value = quantity.value(object);
      if (!value || !std::isfinite(*value)) continue;
      Curve& curve = curves[object.id];
      curve.confirmed = curve.confirmed || object.state == ObjectState::kConfirmed;
      if (curve.points.size() > 1 && x - curve.points[curve.points.size() - 2].x < 1.0f &&
          curve.points.back().y != *value) {
        // Two points a column keep its extremes.
        ImVec2& a = curve.points[curve.points.size() - 2];
        ImVec2& b = curve.points.back();
        if (*value < std::min(a.y, b.y)) (a.y < b.y ? a : b).y = *value;
        if (*value > std::max(a.y, b.y)) (a.y > b.y ? a : b).y = *value;
        continue;
      }
      curve.points.emplace_back(x, *value);
    }
  }
  if (context.confirmed_only)
    std::erase_if(curves, [&](const auto& entry) {
      return !entry.second.confirmed && entry.first != context.selection.object;
    });
  return curves;
}

/// Rounds up to 1, 2 or 5 times a power of ten.
float NiceAbove(float value) {
  if (value <= 0) return 1;
  const float power = std::pow(10.0f, std::floor(std::log10(value)));
  for (const float step : {1.0f, 2.0f, 5.0f}) {
    if (value <= step * power) return step * power;
  }
  return 10 * power;
}

}  // namespace

std::span<const PlottedQuantity> PlottedQuantities() { return kQuantities; }

std::string ValueNow(const FrameContext& context, const PlottedQuantity& quantity) {
  for (const auto& sample : context.shown_playback().history->frames) {
    if (sample == nullptr || sample->frame != context.playback->frame) continue;
    for (const ObjectSample& object : sample->objects) {
      if (object.id != context.selection.object) continue;
      const auto value = quantity.value(object);
      if (value) return fmt::format("{:.3g} {}", *value, quantity.unit);
    }
  }
  return "";
}

void DrawPlot(const FrameContext& context, const TimeAxis& axis, float label_x, float y0, float y1,
              const PlottedQuantity& quantity) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.AddRectFilled({axis.x0, y0}, {axis.x1, y1}, colors::kInset, context.Scaled(2));
  const std::map<ObjectId, Curve> curves = CurvesOf(context, axis, quantity);
  float low = 0, high = 0;
  const bool has_selected = curves.contains(context.selection.object);
  for (const auto& [id, curve] : curves) {
    // The spread of what is just born would dwarf everything else.
    if (has_selected ? id != context.selection.object : !curve.confirmed) continue;
    for (const ImVec2& point : curve.points) {
      low = std::min(low, point.y);
      high = std::max(high, point.y);
    }
  }
  high = NiceAbove(high);
  if (low < 0) low = -NiceAbove(-low);
  const float font = context.fonts.small->FontSize;
  const std::string space = *quantity.unit == '\0' ? "" : " ";
  TrackText(context, {label_x, y0 - 1}, colors::kFaint,
            fmt::format("{:g}{}{}", high, space, quantity.unit));
  if (y1 - y0 > 2.2f * font)
    TrackText(context, {label_x, y1 - font}, colors::kFaint, fmt::format("{:g}", low));
  if (curves.empty()) {
    if (!context.shown_playback().history->frames.empty())
      TrackText(context, {axis.x0 + context.Scaled(8), 0.5f * (y0 + y1 - font)}, colors::kFaint,
                quantity.nothing);
    return;
  }
  const auto y_of = [&](float value) { return y1 - (value - low) / (high - low) * (y1 - y0); };
  draw.PushClipRect({axis.x0, y0}, {axis.x1, y1}, true);
  if (low < 0) draw.AddLine({axis.x0, y_of(0)}, {axis.x1, y_of(0)}, colors::kBorder);
  std::vector<ImVec2> points;
  const auto draw_curve = [&](ObjectId id, const Curve& curve, bool selected) {
    points.clear();
    const ImU32 color = WithAlpha(OnPanel(context.ColorOf(id)), selected          ? 1.0
                                                                : curve.confirmed ? 0.5
                                                                                  : 0.25);
    const float width = context.Scaled(selected ? 2.0 : 1.0);
    const bool dashed = context.LookOf(id).dashed;
    const float gap = std::max(3.0f, 2.5f * (axis.XOf(1) - axis.XOf(0)));
    for (const ImVec2& point : curve.points) {
      if (!points.empty() && point.x - points.back().x > gap) {
        Polyline(context, draw, points, color, width, dashed);
        points.clear();
      }
      points.emplace_back(point.x, y_of(point.y));
    }
    Polyline(context, draw, points, color, width, dashed);
  };
  for (const auto& [id, curve] : curves) {
    if (id != context.selection.object) draw_curve(id, curve, false);
  }
  if (has_selected) draw_curve(context.selection.object, curves.at(context.selection.object), true);
  draw.PopClipRect();
}

}  // namespace plumbline
