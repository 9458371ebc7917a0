// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/base/ids.h"
#include "engine/models/model_database.h"
#include "engine/render/renderer.h"

namespace plumbline {

/// An object at its mean state.
struct PlacedModel {
  ObjectId object;
  ModelId label;
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
};

/// Draws mean states, at half the image's size, to learn who hides whom. Lives in the mapper's
/// thread.
class OcclusionRenderer {
 public:
  static Result<std::unique_ptr<OcclusionRenderer>> Create(
      std::shared_ptr<const ModelDatabase> database);

  /// Nearest and second nearest object of every pixel.
  RenderedMaps Render(const PinholeCamera& camera, const Eigen::Isometry3d& cam_from_world,
                      std::span<const PlacedModel> objects);

 private:
  OcclusionRenderer() = default;
  std::unique_ptr<RenderContext> context_;
  std::unique_ptr<Renderer> renderer_;
  std::vector<int> mesh_of_model_;
};

/// Z [m] of the nearest surface that is not the object's own; 0 none. Empty if nothing is drawn.
cv::Mat OccluderDepth(const RenderedMaps& maps, ObjectId object);

}  // namespace plumbline
