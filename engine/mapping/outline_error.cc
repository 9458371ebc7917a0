// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/outline_error.h"

#include <vector>

namespace plumbline {
namespace {

/// Of the numerical derivative, at that focal length.
constexpr double kOffsetStep_px = 1, kOffsetFocal_px = 500;

}  // namespace

Eigen::Matrix4d OutlineSensitivity(const HypothesisScorer& scorer, const MapFrame& map,
                                   std::vector<JudgingView> views,
                                   std::span<const PoseHypothesis> hypotheses,
                                   const PoseHypothesis& from, const MapperOptions& options,
                                   double sharpness) {
  Eigen::Matrix4d sensitivity = Eigen::Matrix4d::Zero();
  if (hypotheses.empty()) return sensitivity;
  double weight = 0;
  for (const JudgingView& view : views) weight += view.weight;
  const Eigen::Index count = static_cast<Eigen::Index>(hypotheses.size());
  const CadModel& model = map.database->model(from.label);
  Eigen::Matrix4Xd poses(4, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const PoseHypothesis& hypothesis = hypotheses[static_cast<std::size_t>(i)];
    poses.col(i) << hypothesis.center_in_world - from.center_in_world,
        AzimuthDifference(model, hypothesis.azimuth_rad, from.azimuth_rad);
  }
  poses.colwise() -= poses.rowwise().mean().eval();
  std::array<std::vector<double>, 8> sums;
  sums.fill(std::vector<double>(hypotheses.size(), 0.0));
  for (JudgingView& view : views) {
    const double offset_px = kOffsetStep_px * view.view.camera.fx / kOffsetFocal_px;
    const SideScores scores = scorer.ScoreSides(view.view, map.upright, hypotheses, offset_px);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      view.view.outline_offsets_px = SideOffsets(k, offset_px);  // where its pose may err
      const std::vector<float> terms = EdgeTerms(scorer, view.view, map.upright, hypotheses,
                                                 scores[k], view.normalizer, options.beta);
      for (std::size_t i = 0; i < terms.size(); ++i)
        sums[k][i] += view.weight * (options.beta * terms[i]);
    }
  }
  const double scale = ViewScale(weight, sharpness, options) / (2 * kOffsetStep_px);
  for (std::size_t side = 0; side < 4; ++side) {
    const Eigen::VectorXd slopes = scale * (Eigen::VectorXd::Map(sums[side].data(), count) -
                                            Eigen::VectorXd::Map(sums[side + 4].data(), count));
    sensitivity.col(static_cast<Eigen::Index>(side)) = poses * slopes / static_cast<double>(count);
  }
  return sensitivity;
}

Eigen::Matrix4d OutlineCovariance(const Eigen::Matrix4d& sensitivity, double all_around_std_px,
                                  double side_std_px) {
  const Eigen::Vector4d grown = all_around_std_px * sensitivity.rowwise().sum();
  return grown * grown.transpose() +
         side_std_px * side_std_px * sensitivity * sensitivity.transpose();
}

}  // namespace plumbline
