// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/vision/viewpoint_model.h"

namespace plumbline {

/// A contour sample of a hypothesis inside the image, and what it finds there.
struct ContourPointFound {
  Eigen::Vector2f pixel{0, 0};
  Eigen::Vector2f outwards{0, 0};  ///< Unit normal of the contour in the image.
  bool seen = false;  ///< False: behind another object, or before one that looks like it.
  float hit = 0;      ///< Best hit, in [0, 1], along its rim's included.
};

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
  /// Each contour is projected once; leaves boxes empty.
  std::vector<HypothesisScore> ScoreShifts(const ScoringView& view, const UprightFrame& upright,
                                           std::span<const PoseHypothesis> hypotheses,
                                           std::span<const ImageShift> shifts) const override;
  /// The samples that Score() sums over, inner lines included whether the view counts them or not:
  /// those that are not inside the image are left out.
  std::vector<ContourPointFound> PointsFound(const ScoringView& view, const UprightFrame& upright,
                                             const PoseHypothesis& hypothesis) const;

 private:
  template <typename ScoreOne>
  void ForEach(const ScoringView& view, const UprightFrame& upright,
               std::span<const PoseHypothesis> hypotheses, const ScoreOne& score_one) const;

  std::vector<std::shared_ptr<const ViewpointModel>> models_;
  std::shared_ptr<const ModelDatabase> database_;
};

}  // namespace plumbline
