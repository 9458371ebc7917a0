// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/mapping/key_frames.h"
#include "engine/mapping/likelihood.h"

namespace plumbline {

/// An image to judge hypotheses of one object by.
struct JudgingView {
  ScoringView view;
  const FrameDetections* detections = nullptr;
  float normalizer =
      0;  ///< EdgeNormalizer, fixed so that log-likelihoods of different calls compare.
};

/// Log-likelihood of each hypothesis over all views, plus the floor prior.
std::vector<double> JudgeHypotheses(const HypothesisScorer& scorer, const MapFrame& map,
                                    std::span<const JudgingView> views,
                                    std::span<const PoseHypothesis> hypotheses,
                                    const MapperOptions& options);

struct MoveInput {
  std::vector<PoseHypothesis> particles;  ///< Equally weighted.
  std::vector<PoseHypothesis> newcomers;  ///< Fresh draws of the birth prior, may be empty.
  bool wide = false;                      ///< Also look around widely and at the known ambiguities.
};

/// Resample-move (Gilks and Berzuini 2001) on a memory of views: proposes neighbours of the
/// particles, their ambiguities (turned by half and quarter turns about axes inside the object) and
/// newcomers, and draws `count` particles from the posterior over all views, annealed from coarse
/// to fine steps. See docs/algorithms/semantic_filter.md.
std::vector<PoseHypothesis> ResampleMove(const HypothesisScorer& scorer, const MapFrame& map,
                                         std::span<const JudgingView> views, const MoveInput& input,
                                         int count, const MapperOptions& options, RandomKey key);

}  // namespace plumbline
