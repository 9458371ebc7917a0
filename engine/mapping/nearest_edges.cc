// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/nearest_edges.h"

#include <algorithm>

namespace plumbline {
namespace {

/// Of a contour. Its points are a few hundred, not every pixel: of a contour that all but lies
/// outside the image, the two or three inside may all be on edges.
constexpr float kLeastVisible = 0.25f;

/// The authors' renderer draws nothing nearer or farther.
constexpr double kNearest_m = 0.05, kFarthest_m = 10;

EdgeMap Above(const EdgeMap& edges, int threshold) {
  return {edges.probability >= threshold, edges.angle};  // 255 or 0
}

OrientedTableOptions Table(double search_px, const PaperOptions& options, HitProfile profile) {
  OrientedTableOptions table;
  table.radius_px = search_px;
  table.power = 1;
  table.min_agreement = options.edge_agreement;
  table.profile = profile;
  return table;
}

}  // namespace

NearestEdges::NearestEdges(const EdgeMap& edges, double search_px, const PaperOptions& options)
    : search_px_(search_px),
      found_(Above(edges, options.edge_threshold), Table(search_px, options, HitProfile::kFlat)),
      nearness_(Above(edges, options.edge_threshold),
                Table(search_px, options, HitProfile::kLinear)) {}

std::vector<EdgeMatch> NearestEdges::Match(const HypothesisScorer& scorer, ScoringView view,
                                           const UprightFrame& upright,
                                           std::span<const PoseHypothesis> hypotheses) const {
  view.inner_lines = false;
  std::vector<HypothesisScore> found(hypotheses.size()), near(hypotheses.size());
  view.table = &found_;
  scorer.Score(view, upright, hypotheses, found);
  view.table = &nearness_;
  scorer.Score(view, upright, hypotheses, near);
  std::vector<EdgeMatch> matches(hypotheses.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    EdgeMatch& match = matches[i];
    match.visible_m = found[i].visible_m;
    match.whole_box = found[i].whole_box;
    match.visible_box = found[i].visible_box;
    const double depth_m = (view.cam_from_world * hypotheses[i].center_in_world).z();
    if (depth_m < kNearest_m || depth_m > kFarthest_m ||
        found[i].visible_m <= kLeastVisible * found[i].total_m) {
      continue;
    }
    // Scores are sums of (hit - chance); their means are wanted.
    const double hits = found[i].agreement_m / found[i].visible_m + found_.chance();
    const double nearness = near[i].agreement_m / near[i].visible_m + nearness_.chance();
    match.ratio = std::clamp(hits, 0.0, 1.0);
    if (match.ratio > 0)
      match.distance_px = std::max(0.0, (search_px_ + 1) * (1 - nearness / match.ratio));
  }
  return matches;
}

std::vector<NearestEdges> SearchLevels(const EdgeMap& edges, const PaperOptions& options) {
  std::vector<EdgeMap> sizes = {edges};
  while (static_cast<int>(sizes.size()) < options.levels) sizes.push_back(HalfSize(sizes.back()));
  std::vector<NearestEdges> levels;
  double search_px = options.search_px;
  for (auto size = sizes.rbegin(); size != sizes.rend(); ++size)
    levels.emplace_back(*size, search_px /= 2, options);
  return levels;
}

}  // namespace plumbline
