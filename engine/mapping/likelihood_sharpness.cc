// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/likelihood_sharpness.h"

#include <algorithm>
#include <array>

namespace plumbline {
namespace {

constexpr double kStepAcross_px = 1, kStepFocal_px = 500;
/// What stands for both before anything is measured: about one look at one object.
constexpr double kPriorCurvature = 0.5;
/// Looks at one object that say as much of it as all others do.
constexpr double kLooksOfSequence = 5;
constexpr double kLeastSharpness = 0.2, kMostSharpness = 16;

}  // namespace

ViewSlope SlopeOf(const HypothesisScorer& scorer, const JudgingView& view, const MapFrame& map,
                  const PoseHypothesis& pose, const MapperOptions& options) {
  const double depth = (view.view.cam_from_world * pose.center_in_world).z();
  const double step = kStepAcross_px * depth / kStepFocal_px;
  const Eigen::Matrix3d cam_axes_in_world = view.view.cam_from_world.linear().transpose();
  std::array<PoseHypothesis, 5> poses;
  poses.fill(pose);
  for (int axis = 0; axis < 2; ++axis) {
    poses[1 + 2 * axis].center_in_world += step * cam_axes_in_world.col(axis);
    poses[2 + 2 * axis].center_in_world -= step * cam_axes_in_world.col(axis);
  }
  const std::vector<Likelihood> at =
      Evaluate(scorer, view.view, map, nullptr, poses, view.normalizer, options);
  ViewSlope result;
  for (int axis = 0; axis < 2; ++axis) {
    const double there = options.beta * at[1 + 2 * axis].phi_edge,
                 back = options.beta * at[2 + 2 * axis].phi_edge,
                 here = options.beta * at[0].phi_edge;
    const double slope = (there - back) / (2 * kStepAcross_px);
    result.squared_slope += slope * slope;
    result.curvature -= (there + back - 2 * here) / (kStepAcross_px * kStepAcross_px);
  }
  return result;
}

double LikelihoodSharpness::ValueWithin(const LikelihoodSharpness& sequence) const {
  const double share = kLooksOfSequence / (1 + sequence.looks_);
  return std::clamp(
      (share * (kPriorCurvature + std::max(0.0, sequence.curvature_)) + std::max(0.0, curvature_)) /
          (share * (kPriorCurvature + sequence.squared_slope_) + squared_slope_),
      kLeastSharpness, kMostSharpness);
}

}  // namespace plumbline
