// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/geometry/box.h"
#include "engine/vision/two_stage_sidecar.h"

namespace plumbline {

/// A region that may show an object of any category. All corners here are [px of the network's
/// input] from its edge: the input spans [0, width] x [0, height].
struct RegionProposal {
  Box2 box;
  float score;  ///< Probability of an object, in [0, 1].
};

/// What the trunk says of one level.
struct ProposalLevel {
  cv::Mat tensor;     ///< 1 x (features + anchors + 4 anchors) x rows x columns.
  int first = 0;      ///< The channel at which objectness begins.
  int stride_px = 1;  ///< Of a cell.
};

/// The boxes centred on the origin, ratio by ratio, rounded to whole half sides as torchvision
/// does.
std::vector<Box2> AnchorsOfCell(const AnchorSettings& settings);

/// `reference` moved and resized as four numbers of a network say: shifts by shares of its sides,
/// logarithms of the factors of its sides (at most 1000/16), each times its weight.
Box2 MovedBox(const Box2& reference, const std::array<float, 4>& deltas,
              const std::array<float, 4>& weights);

/// The part within [0, size.width] x [0, size.height].
Box2 ClippedBox(const Box2& box, const cv::Size2f& size);

/// The first stage: anchors that the network moved, clipped to the image, the best of each level
/// without those that a better one covers, the best of all levels; by falling score.
/// @param image  [px of the input] that the image spans, from the upper left corner.
std::vector<RegionProposal> ProposeRegions(std::span<const ProposalLevel> levels,
                                           const TwoStageSettings& settings,
                                           const cv::Size2f& image);

}  // namespace plumbline
