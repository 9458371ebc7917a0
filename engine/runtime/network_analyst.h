// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/snapshot/frame_analysis.h"
#include "engine/vision/detector.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {

struct MapSnapshot;

/// Asks networks about frames that are shown; keeps those it was last asked for. Use it in one
/// thread.
class NetworkAnalyst {
 public:
  /// @param choice  `builtin`, `builtin-half`, `gradient` or FILE.onnx.
  OtherEdges EdgesOf(const cv::Mat& image, const std::string& choice);
  /// Of the category and the visible box of `object`. @param recipe  Says which detector; null or
  /// the sequence's own: the proposals of the frame.
  ScoreMap ScoresOf(const MapSnapshot& snapshot, ObjectId object, const RunRecipe* recipe);

 private:
  /// By the run's network; null where it has none or it cannot be loaded (`problem` says why).
  const FrameDetections* Detect(const MapSnapshot& snapshot, const RunRecipe* recipe,
                                std::string& problem);

  std::string edges_choice_, edges_problem_;
  std::unique_ptr<EdgeDetector> edges_;
  std::string detector_choice_, detector_problem_;
  std::unique_ptr<Detector> detector_;
  std::unique_ptr<const FrameDetections> detections_;
};

}  // namespace plumbline
