// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/geometry/box.h"
#include "engine/vision/two_stage_sidecar.h"

namespace plumbline {

/// A map of features: the channels of a cell lie side by side, cells row by row.
struct FeatureMap {
  int rows = 0, columns = 0, channels = 0;
  int stride = 1;  ///< [px of the network's input] of a cell.
  std::vector<float> values;
};

/// From channels [first, first + count) of a tensor 1 x channels x rows x columns.
FeatureMap MakeFeatureMap(const cv::Mat& tensor, int first, int count, int stride);

/// Which of `maps` a box is cropped from: the larger, the coarser.
int CropLevel(const Box2& box, std::span<const FeatureMap> maps, const TwoStageSettings& settings);

/// Crops of all boxes as a tensor N x channels x size x size: RoIAlign as torchvision has it
/// (aligned=False), each box from its level (docs/algorithms/two_stage.md).
/// @param boxes  [px of the network's input], from its edge, not empty. Beyond the map by more than
///               a cell there are zeros.
/// @param filled  N, at least the number of boxes; crops of those that are missing are zeros.
cv::Mat CropRegions(std::span<const FeatureMap> maps, std::span<const Box2> boxes, int filled,
                    const TwoStageSettings& settings);

}  // namespace plumbline
