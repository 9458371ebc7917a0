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
  std::string bytes;                            ///< The file as it is.
  std::string content_hash;                     ///< Of them.
};

/// Errors: kNotFound, kCorrupt (no ONNX file, or cut short).
Result<OnnxFile> ReadOnnxFile(const std::filesystem::path& file);

}  // namespace plumbline
