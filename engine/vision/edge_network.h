// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {

/// An ONNX edge network (input 1x3xHxW, output 1x1xHxW in [0, 1]) by its sidecar. An image that
/// fits into the network's input is padded by reflection; a larger one is shrunk to fit first and
/// its edges are enlarged before thinning. Where the sidecar has no calibration, one measured for
/// networks trained with balanced classes is used. Errors: kNotFound, kCorrupt, kInvalidInput,
/// kUnsupported.
Result<std::unique_ptr<EdgeDetector>> LoadEdgeNetwork(const std::filesystem::path& onnx_file,
                                                      const EdgeOptions& options);

}  // namespace plumbline
