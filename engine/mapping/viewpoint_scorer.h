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

 private:
  std::vector<std::shared_ptr<const ViewpointModel>> models_;
  std::shared_ptr<const ModelDatabase> database_;
};

}  // namespace plumbline
