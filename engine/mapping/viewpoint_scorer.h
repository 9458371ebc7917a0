// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/vision/viewpoint_model.h"

namespace plumbline {

/// The fast scorer: a hypothesis costs a look-up of its view, a projection of a few hundred contour
/// points and their table look-ups.
class ViewpointScorer : public HypothesisScorer {
 public:
  /// @param models     By ModelId; null for models that are never scored.
  /// @param database   Gives the models' centres.
  ViewpointScorer(std::vector<std::shared_ptr<const ViewpointModel>> models,
                  std::shared_ptr<const ModelDatabase> database);
  void Score(const ScoringView& view, const UprightFrame& upright,
             std::span<const PoseHypothesis> hypotheses,
             std::span<HypothesisScore> scores) const override;
  /// Each contour is projected once; leaves boxes empty.
  SideScores ScoreSides(const ScoringView& view, const UprightFrame& upright,
                        std::span<const PoseHypothesis> hypotheses,
                        double offset_px) const override;

 private:
  template <typename ScoreOne>
  void ForEach(const ScoringView& view, const UprightFrame& upright,
               std::span<const PoseHypothesis> hypotheses, const ScoreOne& score_one) const;

  std::vector<std::shared_ptr<const ViewpointModel>> models_;
  std::shared_ptr<const ModelDatabase> database_;
};

}  // namespace plumbline
