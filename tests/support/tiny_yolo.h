// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace plumbline {

/// A network that ends node for node as exporters write YOLOv8 and its followers.
struct TinyYolo {
  int width = 64, height = 64;
  int categories = 3, best_category = 1;
  int bins = 16;              ///< 1: distances as they are, as in YOLO26.
  bool by_level = true;       ///< Sides and scores are joined level by level; else all of each.
  bool chosen = false;        ///< It chooses boxes itself, as YOLOv10 does.
  int masks = 0;              ///< Coefficients a box; a second output has the masks.
  bool free_size = false;     ///< Sizes are open, and shapes are computed.
  bool small_levels = false;  ///< Strides from 4 on instead of 8.
  bool exponential = false;   ///< Its distances pass an Exp: another kind of network.
};

/// Writes it as ONNX (opset 11). Every cell gives a box of 16 px around its middle, and the best
/// category 0.8.
void WriteTinyYolo(const std::filesystem::path& file, const TinyYolo& yolo = {});

}  // namespace plumbline
