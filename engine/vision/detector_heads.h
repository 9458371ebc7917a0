// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/vision/detector.h"
#include "engine/vision/network.h"

namespace plumbline {

/// Boxes and scores from the outputs of a detector of any dense kind (docs/formats.md). Every cell
/// proposes its best category; a box of any category scores the maximum over all cells, whatever is
/// proposed, of score * IoU. Errors: kInvalidInput if the outputs are not of the shapes that the
/// sidecar's kind and categories ask for (naming the shapes).
Result<std::unique_ptr<const FrameDetections>> DecodeDetections(const std::vector<cv::Mat>& outputs,
                                                                const NetworkSidecar& sidecar,
                                                                const FittedImage& fitted,
                                                                const DetectorOptions& options);

}  // namespace plumbline
