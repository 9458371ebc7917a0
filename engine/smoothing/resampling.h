// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/base/random.h"
#include "engine/mapping/judging.h"
#include "engine/mapping/map_object.h"

namespace plumbline {

/// A view of an object in which its hypotheses are scored, with what the score refers to.
struct ObjectImage {
  std::shared_ptr<const OrientedTable> table;
  std::shared_ptr<const FrameDetections> detections;
  JudgingView judging;  ///< Refers to the two above.
};

/// Draws the object's particles from its posterior over all `images`, starting from those it has
/// and what a search about them finds, and summarises them: modes, labels, mean and covariance.
/// Nothing changes without images.
void Resample(const HypothesisScorer& scorer, const MapFrame& map,
              std::span<const ObjectImage> images, const MapperOptions& options, RandomKey key,
              MapObject& object);

/// Share of the belief near the mean pose, whatever the shape.
double BeliefInMean(const MapObject& object, const MapFrame& map);

}  // namespace plumbline
