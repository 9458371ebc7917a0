// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/mapping/mapper_options.h"
#include "engine/mapping/particle_set.h"
#include "engine/vision/detector.h"

namespace plumbline {

/// Both terms of one hypothesis in one image.
struct Likelihood {
  float phi_cnn = 0;
  float phi_edge = 0;
  float visible_fraction = 0;
  Box2 whole_box, visible_box;
};

/// What Phi_cnn of a shape of this category and these bounds is multiplied by: `large_alpha` if it
/// is large (LengthScale), else `alpha`.
double DetectorWeight(std::string_view category, const Eigen::AlignedBox3f& bounds,
                      const MapperOptions& options);

/// Phi_edge divides the agreement of a hypothesis by the visible length of its contour, at least by
/// this length, which is common to all hypotheses of one object in one image: so neither showing
/// few edges nor showing many is an advantage. It is a share of the typical visible length, at
/// least a fifth of the typical whole length; 0 if nothing shows.
float EdgeNormalizer(std::span<const HypothesisScore> scores);

/// The edge term of each hypothesis. Where the view's pose errs by one of its shifts it is the
/// marginal over them, (1/sharpness) log sum of w exp(sharpness Phi_edge): some shift has to
/// explain the whole contour.
/// @param scores  Of the hypotheses, where the pose says.
/// @param sharpness  beta for a likelihood; large for the best of the shifts.
std::vector<float> EdgeTerms(const HypothesisScorer& scorer, const ScoringView& view,
                             const UprightFrame& upright,
                             std::span<const PoseHypothesis> hypotheses,
                             std::span<const HypothesisScore> scores, float normalizer,
                             double sharpness);

/// Scores hypotheses of one category in one image.
/// @param detections  May be null: then phi_cnn is 0.
/// @param normalizer  As from EdgeNormalizer; nothing: taken from these hypotheses.
std::vector<Likelihood> Evaluate(const HypothesisScorer& scorer, const ScoringView& view,
                                 const MapFrame& map, const FrameDetections* detections,
                                 std::span<const PoseHypothesis> hypotheses,
                                 std::optional<float> normalizer, const MapperOptions& options);

}  // namespace plumbline
