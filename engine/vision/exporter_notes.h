// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/vision/onnx_file.h"

namespace plumbline {

/// The names of categories as Ultralytics' exporters note them, {0: 'person', 1: ..} or
/// ['person', ..], as COCO names them; empty where there are none.
std::vector<std::string> NotedNames(const OnnxFile& onnx);

/// The size of the input [px] as they note it: two whole numbers, height first.
std::optional<cv::Size> NotedSize(const OnnxFile& onnx);

}  // namespace plumbline
