// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/dataset/sequence.h"
#include "engine/mapping/occlusion.h"
#include "engine/models/model_database.h"
#include "engine/pipeline/run_recipe.h"
#include "engine/snapshot/map_snapshot.h"
#include "engine/vision/edge_detector.h"

namespace plumbline {

/// Outlines of the objects in an id map (CV_16U), in pixels of an image of `image_size`, which may
/// be a multiple of the map's.
std::vector<OutlineView> OutlinesOf(const cv::Mat& id, cv::Size image_size);

/// Computes again what a snapshot shows besides its report, from what the run was made from: image,
/// edges, Z-buffer and outlines. Nothing is detected or mapped. Use it in one thread.
class FramePictures {
 public:
  /// @param edges  Those of the run; nothing: DefaultEdges.
  static Result<std::unique_ptr<FramePictures>> Create(
      std::shared_ptr<const Sequence> sequence, std::shared_ptr<const ModelDatabase> database,
      const std::optional<EdgeChoice>& edges);
  /// Without a sequence: Z-buffer and outlines only.
  FramePictures(const PinholeCamera& camera, const ModelDatabase& database)
      : camera_(camera), renderer_(database) {}

  /// An image or edges that cannot be read stay empty.
  std::shared_ptr<MapSnapshot> Make(FrameReport report);

 private:
  PinholeCamera camera_;
  std::shared_ptr<const Sequence> sequence_;  ///< Null without images.
  std::unique_ptr<EdgeDetector> edges_;
  OcclusionRenderer renderer_;
};

}  // namespace plumbline
