// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace plumbline {

/// Boxes that a level of the pyramid starts from, centred on the corners of its cells: one for each
/// ratio and size.
struct AnchorSettings {
  std::vector<float> sizes;   ///< [px of the input], the root of the area.
  std::vector<float> ratios;  ///< Height / width.
  int count() const { return static_cast<int>(sizes.size() * ratios.size()); }
};

/// What the sidecar of a two-stage network says beside what all say (docs/algorithms/two_stage.md).
struct TwoStageSettings {
  std::vector<AnchorSettings> anchors;                   ///< As many as there are strides.
  int proposals_before_nms = 1000;                       ///< The best of each level.
  int proposals_after_nms = 1000;                        ///< The best of all levels.
  float proposal_nms_iou = 0.7f;                         ///< Within a level.
  float proposal_min_score = 0;                          ///< Probability that there is an object.
  std::array<float, 4> proposal_weights = {1, 1, 1, 1};  ///< x, y, width, height are divided by.
  int crop_size = 7;                                     ///< Bins across and down.
  int crop_sampling = 2;  ///< Samples of a bin across and down; 0: as many as cells.
  int crop_levels = 1;    ///< Crops are taken from the first levels.
  /// The head takes crops as columns, 1 x (features * bins) x N x 1, not N x features x bins.
  bool crop_columns = false;
  float canonical_scale = 224;  ///< [px of the input] A square of this size is cropped from ..
  int canonical_level = 4;      ///< .. the level of stride 2^this.
  std::array<float, 4> box_weights = {10, 10, 5, 5};
  int most_boxes = 100;  ///< In an image, after the last NMS.
};

/// Reads into `settings`; what is wrong as the end of a sentence, nothing if all is well.
/// @param levels  How many strides the sidecar has.
std::optional<std::string> ReadTwoStage(const nlohmann::json& sidecar, std::size_t levels,
                                        TwoStageSettings& settings);
void WriteTwoStage(const TwoStageSettings& settings, nlohmann::json& sidecar);

}  // namespace plumbline
