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

std::vector<HypothesisScore> HypothesisScorer::ScoreShifts(
    const ScoringView& view, const UprightFrame& upright,
    std::span<const PoseHypothesis> hypotheses, std::span<const ImageShift> shifts) const {
  std::vector<HypothesisScore> scores(shifts.size() * hypotheses.size());
  std::span<HypothesisScore> rest = scores;
  ScoringView moved = view;
  for (const ImageShift& shift : shifts) {
    moved.camera.cx = view.camera.cx + shift.x_px;
    moved.camera.cy = view.camera.cy + shift.y_px;
    Score(moved, upright, hypotheses, rest.first(hypotheses.size()));
    rest = rest.subspan(hypotheses.size());
  }
  return scores;
}

}  // namespace plumbline
