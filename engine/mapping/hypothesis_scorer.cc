// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/hypothesis_scorer.h"

namespace plumbline {

std::array<double, 4> SideOffsets(std::size_t k, double offset_px) {
  std::array<double, 4> offsets = {};
  offsets[k % 4] = k < 4 ? offset_px : -offset_px;
  return offsets;
}

SideScores HypothesisScorer::ScoreSides(const ScoringView& view, const UprightFrame& upright,
                                        std::span<const PoseHypothesis> hypotheses,
                                        double offset_px) const {
  ScoringView moved = view;
  SideScores scores;
  for (std::size_t k = 0; k < scores.size(); ++k) {
    scores[k].resize(hypotheses.size());
    moved.outline_offsets_px = SideOffsets(k, offset_px);
    Score(moved, upright, hypotheses, scores[k]);
  }
  return scores;
}

}  // namespace plumbline
