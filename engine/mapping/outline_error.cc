// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/outline_error.h"

#include <vector>

namespace plumbline {
namespace {

/// Of the numerical derivative, at that focal length.
constexpr double kOffsetStep_px = 1, kOffsetFocal_px = 500;

}  // namespace

Eigen::Vector4d OutlineSensitivity(const HypothesisScorer& scorer, const MapFrame& map,
                                   std::vector<JudgingView> views,
                                   std::span<const PoseHypothesis> hypotheses,
                                   const PoseHypothesis& from, const MapperOptions& options,
                                   double sharpness) {
  if (hypotheses.empty()) return Eigen::Vector4d::Zero();
  double weight = 0;
  for (JudgingView& view : views) {
    weight += view.weight;
    view.detections = nullptr;  // boxes know nothing of outlines
  }
  const auto moved_by = [&](double step_px) {
    for (JudgingView& view : views)
      view.view.outline_offset_px = step_px * view.view.camera.fx / kOffsetFocal_px;
    return SumOverViews(scorer, map, views, hypotheses, options);
  };
  const std::vector<double> outside = moved_by(kOffsetStep_px), inside = moved_by(-kOffsetStep_px);
  const double scale = ViewScale(weight, sharpness, options) / (2 * kOffsetStep_px);
  const CadModel& model = map.database->model(from.label);
  Eigen::Vector4d pose_sum = Eigen::Vector4d::Zero(), product_sum = Eigen::Vector4d::Zero();
  double slope_sum = 0;
  for (std::size_t i = 0; i < hypotheses.size(); ++i) {
    Eigen::Vector4d pose;
    pose << hypotheses[i].center_in_world - from.center_in_world,
        AzimuthDifference(model, hypotheses[i].azimuth_rad, from.azimuth_rad);
    const double slope = scale * (outside[i] - inside[i]);
    pose_sum += pose;
    slope_sum += slope;
    product_sum += slope * pose;
  }
  const double count = static_cast<double>(hypotheses.size());
  return product_sum / count - slope_sum / count * pose_sum / count;
}

}  // namespace plumbline
