// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/vision/detector.h"

namespace plumbline {

/// What the detector says about one image, from the network's raw output (1 x (5 + categories) x
/// rows x columns: objectness, then tanh/sigmoid arguments of the box, then class probabilities).
/// Every cell proposes its best category; top-down, the cells score a box for any category as max
/// over cells of score * IoU. See docs/algorithms/detector_scores.md.
std::unique_ptr<const FrameDetections> DecodeFastestDet(const cv::Mat& output,
                                                        const cv::Size& image,
                                                        const std::vector<std::string>& categories,
                                                        const DetectorOptions& options);

/// FastestDet (one stage, 22x22 cells) by its sidecar. Errors: kNotFound, kCorrupt, kInvalidInput,
/// kUnsupported.
Result<std::unique_ptr<Detector>> LoadFastestDet(const std::filesystem::path& onnx_file,
                                                 const DetectorOptions& options);

}  // namespace plumbline
