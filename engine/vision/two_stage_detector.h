// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "engine/base/result.h"
#include "engine/vision/detector.h"
#include "engine/vision/network_sidecar.h"

namespace plumbline {

/// Faster R-CNN: regions that may show something, then a second network that looks at crops of the
/// shared features (docs/algorithms/two_stage.md). Top-down scores are the probability that the
/// second stage gives the box itself, rounded to a quarter of a pixel and clipped to the image.
/// Errors: kNotFound, kCorrupt, kInvalidInput, naming the file.
Result<std::unique_ptr<Detector>> CreateTwoStageDetector(const std::filesystem::path& onnx_file,
                                                         NetworkSidecar sidecar,
                                                         const DetectorOptions& options);

/// Ours, which is built into the program (assets/networks/detector). Errors: kCorrupt, if OpenCV
/// cannot run it.
Result<std::unique_ptr<Detector>> BuiltinDetector(const DetectorOptions& options);
/// Of its networks and their sidecar.
std::string HashOfBuiltinDetector();

}  // namespace plumbline
