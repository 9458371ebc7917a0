// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/region_proposals.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr float kLeastSide = 1e-3f;  // [px of the input]
const float kMostGrowth = std::log(1000.0f / 16);

/// An anchor of a level by its place in the tensor.
struct RankedAnchor {
  float objectness;
  int index;  ///< (row * columns + column) * anchors + anchor.
};

std::vector<RankedAnchor> BestAnchors(const ProposalLevel& level, int anchors, int most) {
  const int cells = level.tensor.size[2] * level.tensor.size[3];
  std::vector<RankedAnchor> ranked;
  ranked.reserve(static_cast<std::size_t>(cells) * anchors);
  for (int anchor = 0; anchor < anchors; ++anchor) {
    const float* plane = level.tensor.ptr<float>(0, level.first + anchor);
    for (int cell = 0; cell < cells; ++cell)
      if (std::isfinite(plane[cell])) ranked.push_back({plane[cell], cell * anchors + anchor});
  }
  const auto end = ranked.begin() + std::min<std::ptrdiff_t>(most, std::ssize(ranked));
  std::partial_sort(
      ranked.begin(), end, ranked.end(), [](const RankedAnchor& a, const RankedAnchor& b) {
        return a.objectness != b.objectness ? a.objectness > b.objectness : a.index < b.index;
      });
  ranked.erase(end, ranked.end());
  return ranked;
}

/// By falling score, those left out that overlap a better one too much.
std::vector<RegionProposal> WithoutCovered(const std::vector<RegionProposal>& proposals,
                                           float max_iou) {
  std::vector<RegionProposal> kept;
  for (const RegionProposal& candidate : proposals) {
    const bool covered = std::any_of(kept.begin(), kept.end(), [&](const RegionProposal& better) {
      return Iou(better.box, candidate.box) > max_iou;
    });
    if (!covered) kept.push_back(candidate);
  }
  return kept;
}

std::vector<RegionProposal> ProposeOnLevel(const ProposalLevel& level,
                                           const AnchorSettings& anchor_settings,
                                           const TwoStageSettings& settings,
                                           const cv::Size2f& image) {
  const std::vector<Box2> anchors = AnchorsOfCell(anchor_settings);
  const int count = static_cast<int>(anchors.size()), columns = level.tensor.size[3];
  std::vector<RegionProposal> proposals;
  for (const auto& [objectness, index] : BestAnchors(level, count, settings.proposals_before_nms)) {
    const int cell = index / count, anchor = index % count;
    const auto x = static_cast<float>(cell % columns * level.stride_px),
               y = static_cast<float>(cell / columns * level.stride_px);
    std::array<float, 4> deltas;
    for (int i = 0; i < 4; ++i)
      deltas[i] = level.tensor.ptr<float>(0, level.first + count + 4 * anchor + i)[cell];
    const Box2& at = anchors[anchor];
    const Box2 box = ClippedBox(
        MovedBox({at.x0 + x, at.y0 + y, at.x1 + x, at.y1 + y}, deltas, settings.proposal_weights),
        image);
    const float score = 1 / (1 + std::exp(-objectness));
    if (box.width() >= kLeastSide && box.height() >= kLeastSide &&
        score >= settings.proposal_min_score)
      proposals.push_back({box, score});
  }
  return WithoutCovered(proposals, settings.proposal_nms_iou);
}

}  // namespace

std::vector<Box2> AnchorsOfCell(const AnchorSettings& settings) {
  std::vector<Box2> anchors;
  for (const float ratio : settings.ratios) {
    const float down = std::sqrt(ratio), across = 1 / down;
    for (const float size : settings.sizes) {
      const float half_width = std::nearbyint(across * size / 2),
                  half_height = std::nearbyint(down * size / 2);
      anchors.push_back({-half_width, -half_height, half_width, half_height});
    }
  }
  return anchors;
}

Box2 MovedBox(const Box2& reference, const std::array<float, 4>& deltas,
              const std::array<float, 4>& weights) {
  const float width = reference.width(), height = reference.height();
  const float x = deltas[0] / weights[0] * width + reference.x0 + 0.5f * width;
  const float y = deltas[1] / weights[1] * height + reference.y0 + 0.5f * height;
  const float half_width = 0.5f * width * std::exp(std::min(deltas[2] / weights[2], kMostGrowth));
  const float half_height = 0.5f * height * std::exp(std::min(deltas[3] / weights[3], kMostGrowth));
  return {x - half_width, y - half_height, x + half_width, y + half_height};
}

Box2 ClippedBox(const Box2& box, const cv::Size2f& size) {
  return {std::clamp(box.x0, 0.0f, size.width), std::clamp(box.y0, 0.0f, size.height),
          std::clamp(box.x1, 0.0f, size.width), std::clamp(box.y1, 0.0f, size.height)};
}

std::vector<RegionProposal> ProposeRegions(std::span<const ProposalLevel> levels,
                                           const TwoStageSettings& settings,
                                           const cv::Size2f& image) {
  std::vector<RegionProposal> all;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const auto level = ProposeOnLevel(levels[i], settings.anchors[i], settings, image);
    all.insert(all.end(), level.begin(), level.end());
  }
  std::stable_sort(all.begin(), all.end(), [](const RegionProposal& a, const RegionProposal& b) {
    return a.score > b.score;
  });
  if (std::ssize(all) > settings.proposals_after_nms)
    all.resize(static_cast<std::size_t>(settings.proposals_after_nms));
  return all;
}

}  // namespace plumbline
