// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "engine/mapping/hypothesis_scorer.h"
#include "engine/mapping/paper_options.h"

namespace plumbline {

/// How the visible contour of a hypothesis lies beside the nearest edges. Less than a quarter of a
/// contour matches nothing.
struct EdgeMatch {
  double ratio = 0;             ///< Share of its points with an edge within the search, m / n.
  double distance_px = 0;       ///< Mean distance of those to the nearest edge, d.
  float visible_m = 0;          ///< Length of the visible contour.
  Box2 whole_box, visible_box;  ///< As in HypothesisScore, in pixels of the searched image.

  /// The authors' edge score, (m / n) / d. They add 0.0001 px to d, which serves where edges are
  /// bands and contours thousands of pixels, so that d is never 0. Here edges are thin lines and
  /// contours a few hundred points: the one point that lies on an edge would outweigh all others.
  double Score() const { return ratio / std::max(distance_px, kLeastDistance_px); }
  static constexpr double kLeastDistance_px = 0.5;
};

/// Edges of one image that are above a threshold, to be searched for along contour normals, the
/// nearest first: the search of the authors (docs/algorithms/paper_filter.md). Immutable.
class NearestEdges {
 public:
  NearestEdges(const EdgeMap& edges, double search_px, const PaperOptions& options);

  /// @param view  Of the size of these edges; its table is not read.
  std::vector<EdgeMatch> Match(const HypothesisScorer& scorer, ScoringView view,
                               const UprightFrame& upright,
                               std::span<const PoseHypothesis> hypotheses) const;

 private:
  double search_px_;
  OrientedTable found_;     ///< 1 where there is an edge within reach.
  OrientedTable nearness_;  ///< Falls linearly with the distance of the nearest one.
};

/// Levels of an image from the coarsest to the full one, as the options have them.
std::vector<NearestEdges> SearchLevels(const EdgeMap& edges, const PaperOptions& options);

}  // namespace plumbline
