// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "engine/vision/network_sidecar.h"

namespace plumbline {

/// What a network of no weights says of every cell of its grids, whatever it is shown.
struct TinyNetwork {
  NetworkKind kind = NetworkKind::kEdge;
  int width = 64, height = 64;
  int categories = 3;
  int best_category = 1;
  float score = 0.8f;   ///< Of the best category; others 0.
  bool clips = false;   ///< Its input passes a Clip with bounds as inputs, as new exporters write.
  bool copies = false;  ///< Its biases are copies, as exporters write equal constants.
  bool shapes =
      false;  ///< Its input passes arithmetic about shapes, as torch writes view and chunk.
  bool free_size = false;  ///< The file leaves the size of the input open.
  int masks = 0;           ///< YOLOv5 and v8: coefficients a box; a second output has the masks.
  std::map<std::string, std::string> metadata;
};

/// Writes an ONNX file of the kind's form (opset 11) that OpenCV 4.6 can run. Every cell gives a
/// box of 16 px around its own point or the middle.
void WriteTinyNetwork(const std::filesystem::path& file, const TinyNetwork& network);

/// Writes a two-stage network with its head and sidecar, of 64x64 px, grey levels from 0 to 1. Its
/// feature is the mean grey level of each cell of 8 px; a cell is an object (of 16 px) as far as it
/// is bright; a box is a "couch" with the probability sigmoid(20 (mean of its crop - 1/2)), never a
/// "chair", and stays where it is.
/// @param head_categories  Of the head; the sidecar has the two.
void WriteTinyTwoStage(const std::filesystem::path& file, int head_categories = 2);

}  // namespace plumbline
