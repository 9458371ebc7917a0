// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/inertial/inertial_plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "engine/geometry/angles.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

ImU32 AxisColor(int axis) { return OnPanel(SeriesColor(static_cast<std::size_t>(axis))); }

template <typename Value>
InertialCurve CurveOf(const OwnPoses& poses, ImU32 color, Value value) {
  InertialCurve curve{color, {}, {}};
  for (const OwnPoseReport& frame : poses.frames) curve.values.push_back(value(frame));
  return curve;
}

/// Three axes of a vector, each with twice its standard deviation.
template <typename Value>
void AddBiases(const OwnPoses& poses, int first_spread, double per_unit, Value value,
               InertialPlot& plot) {
  for (int axis = 0; axis < 3; ++axis) {
    plot.curves.push_back(CurveOf(poses, AxisColor(axis), [&](const OwnPoseReport& frame) {
      return frame.world_from_cam ? per_unit * value(frame)[axis] : kNone;
    }));
    plot.curves.back().bound = CurveOf(poses, 0, [&](const OwnPoseReport& frame) {
                                 return 2 * per_unit * frame.vio.spread[first_spread + axis];
                               }).values;
  }
}

std::vector<InertialPlot> PlotsOf(const SequenceView& sequence) {
  const OwnPoses& poses = *sequence.own_poses;
  std::vector<InertialPlot> plots;
  plots.push_back({"turning", "deg/s", "How fast the gyro says that the body turns.", true, {}});
  plots.back().curves.push_back(CurveOf(poses, colors::kAccent, [](const OwnPoseReport& frame) {
    return frame.angular_velocity_rad_s.norm() * kDegPerRad;
  }));
  plots.push_back(
      {"gyro bias", "deg/s", "Three axes, with twice their standard deviation.", false, {}});
  AddBiases(
      poses, 0, kDegPerRad, [](const OwnPoseReport& frame) { return frame.vio.gyro_bias; },
      plots.back());
  plots.push_back({"accelerometer bias",
                   "m/s²",
                   "Three axes, with twice their standard deviation.",
                   false,
                   {}});
  AddBiases(
      poses, 3, 1, [](const OwnPoseReport& frame) { return frame.vio.accel_bias; }, plots.back());
  plots.push_back({"innovations",
                   "ratio",
                   "Normalised innovations squared over their degrees of freedom: about 1 if the "
                   "filter is honest. Red: the 95 % gate of the frame.",
                   true,
                   {}});
  const auto per_dof = [](double sum, const OwnPoseReport& frame) {
    return frame.vio.step.nis_dof > 0 ? sum / frame.vio.step.nis_dof : kNone;
  };
  plots.back().curves.push_back(CurveOf(poses, colors::kBad, [&](const OwnPoseReport& frame) {
    return per_dof(frame.nis_gate, frame);
  }));
  plots.back().curves.push_back(CurveOf(poses, colors::kGood, [&](const OwnPoseReport& frame) {
    return per_dof(frame.vio.step.nis, frame);
  }));
  if (sequence.given_world_from_cam.empty()) return plots;
  plots.push_back({"off the reference",
                   "cm",
                   "Distance from the camera poses that came with the sequence, once both "
                   "trajectories are aligned in heading and position.",
                   true,
                   {}});
  InertialCurve curve{colors::kWarning, {}, {}};
  for (std::size_t i = 0; i < poses.frames.size(); ++i) {
    const auto distance = DistanceFromReference(sequence, static_cast<int>(i));
    curve.values.push_back(distance ? 100 * *distance : kNone);
  }
  plots.back().curves.push_back(std::move(curve));
  return plots;
}

/// Least and greatest value of the curves; bounds count where they do not dwarf them.
std::pair<double, double> RangeOf(const InertialPlot& plot) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const InertialCurve& curve : plot.curves) {
    for (const double value : curve.values) {
      if (std::isnan(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (!(low <= high)) return {0, 1};
  if (plot.from_zero) low = std::min(low, 0.0);
  const double margin = std::max(0.1 * (high - low), 1e-6);
  return {plot.from_zero ? low : low - margin, high + margin};
}

/// Name and range on a line of their own, the curves below it.
void DrawPlot(const FrameContext& context, const InertialPlot& plot, ImVec2 low, ImVec2 high,
              int frame) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const auto limits = RangeOf(plot);
  const double least = limits.first, greatest = limits.second;
  draw.AddText(low, colors::kDimText, fmt::format("{} [{}]", plot.name, plot.unit).c_str());
  const std::string range = fmt::format("{:.3g} to {:.3g}", least, greatest);
  draw.AddText({high.x - ImGui::CalcTextSize(range.c_str()).x, low.y}, colors::kFaint,
               range.c_str());
  low.y += ImGui::GetTextLineHeight() + context.Scaled(1);
  draw.AddRectFilled(low, high, colors::kInset, context.Scaled(2));
  const std::size_t count = plot.curves.front().values.size();
  const auto at = [&](std::size_t i, double value) {
    const double x = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0.5;
    const double y = (value - least) / (greatest - least);
    return ImVec2(low.x + static_cast<float>(x) * (high.x - low.x),
                  high.y - static_cast<float>(y) * (high.y - low.y));
  };
  // More frames than pixels: every n-th is enough to see.
  const std::size_t step = std::max<std::size_t>(
      1, count / std::max<std::size_t>(1, 2 * static_cast<std::size_t>(high.x - low.x)));
  draw.PushClipRect(low, high, true);
  if (least < 0 && greatest > 0) draw.AddLine(at(0, 0), at(count - 1, 0), colors::kFaint);
  for (const InertialCurve& curve : plot.curves) {
    for (std::size_t i = 0; i + step < count && !curve.bound.empty(); i += step) {
      const double value = curve.values[i], bound = curve.bound[i];
      if (std::isnan(value)) continue;
      draw.AddRectFilled(at(i, value + bound), {at(i + step, 0).x, at(i, value - bound).y},
                         WithAlpha(curve.color, 0.22));
    }
    std::vector<ImVec2> points;
    for (std::size_t i = 0; i < count; i += step) {
      if (!std::isnan(curve.values[i])) points.push_back(at(i, curve.values[i]));
    }
    draw.AddPolyline(points.data(), static_cast<int>(points.size()), curve.color, 0,
                     context.Scaled(1.2));
  }
  for (const LoopClosure& closure : context.sequence->own_poses->loops.closures) {
    const float x =
        at(static_cast<std::size_t>(std::clamp(closure.image, 0, static_cast<int>(count) - 1)),
           least)
            .x;
    draw.AddLine({x, low.y}, {x, high.y}, WithAlpha(colors::kAccent, 0.5));
  }
  const float now =
      at(static_cast<std::size_t>(std::clamp(frame, 0, static_cast<int>(count) - 1)), least).x;
  draw.AddLine({now, low.y}, {now, high.y}, colors::kText, context.Scaled(1.2));
  draw.PopClipRect();
}

}  // namespace

std::optional<double> DistanceFromReference(const SequenceView& sequence, int frame) {
  const auto at = static_cast<std::size_t>(frame);
  if (frame < 0 || at >= sequence.given_world_from_cam.size() ||
      at >= sequence.own_poses->frames.size())
    return std::nullopt;
  const auto& given = sequence.given_world_from_cam[at];
  const OwnPoseReport& own = sequence.own_poses->frames[at];
  if (!given || !own.ready) return std::nullopt;
  return (given->translation() - own.world_from_cam->translation()).norm();
}

void InertialPlots::Draw(const FrameContext& context) {
  if (of_ != context.sequence->own_poses) {
    of_ = context.sequence->own_poses;
    plots_ = PlotsOf(*context.sequence);
  }
  const float gap = context.Scaled(4);
  const ImVec2 corner = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
  const std::size_t columns = std::clamp<std::size_t>(
      static_cast<std::size_t>(room.x / context.Scaled(240)), 1, plots_.size());
  const std::size_t rows = (plots_.size() + columns - 1) / columns;
  const float wide = std::max(8.0f, room.x / static_cast<float>(columns) - gap);
  const float tall =
      std::max(2.8f * ImGui::GetTextLineHeight(), room.y / static_cast<float>(rows) - gap);
  for (std::size_t i = 0; i < plots_.size(); ++i) {
    const ImVec2 low(corner.x + static_cast<float>(i % columns) * (wide + gap),
                     corner.y + static_cast<float>(i / columns) * (tall + gap));
    ImGui::SetCursorScreenPos(low);
    ImGui::InvisibleButton(plots_[i].name, {wide, tall});
    LogItem(context, fmt::format("inertial.plot.{}", i));
    Tooltip(context, plots_[i].help);
    DrawPlot(context, plots_[i], low, {low.x + wide, low.y + tall}, context.snapshot->report.frame);
  }
}

}  // namespace plumbline
