// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace plumbline {

/// An input or output of a network.
struct OnnxTensor {
  std::string name;
  std::vector<int> shape;  ///< 0 where the file leaves a length open; empty where it says nothing.
};

/// What an ONNX file says of itself.
struct OnnxFile {
  std::vector<OnnxTensor> inputs;  ///< Without the weights.
  std::vector<OnnxTensor> outputs;
  std::map<std::string, std::string> metadata;  ///< As the exporter wrote it: names, imgsz, ..
  std::string producer;                         ///< Name and version; may be empty.
  /// The network as OpenCV 4.6 can load it: bounds of Clip nodes that are constants are attributes
  /// (as up to opset 10), weights are no inputs, and nobody copies constants.
  std::string for_opencv;
  std::string content_hash;  ///< Of the file as it is.
};

/// Errors: kNotFound, kCorrupt (no ONNX file, or cut short).
Result<OnnxFile> ReadOnnxFile(const std::filesystem::path& file);

}  // namespace plumbline
