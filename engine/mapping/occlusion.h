// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <span>
#include <utility>
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
  double scale = 1;  ///< As of ObjectBelief.
};

/// What stands before each object in one image.
class OcclusionMaps {
 public:
  OcclusionMaps() = default;
  explicit OcclusionMaps(RenderedMaps maps) : maps_(std::move(maps)) {}

  /// With contour, and with a second layer where there is one.
  const RenderedMaps& rendered() const { return maps_; }
  /// Z [m] of the nearest surface that is neither the object's own nor that of what it stands on,
  /// if anything; 0 none. Empty if nothing is drawn. Worked out once for each object: not for two
  /// threads at a time.
  const cv::Mat& DepthBefore(ObjectId object, ObjectId support = {}) const;
  /// The same, and next to nothing along the contours of the others: whatever is scored with it is
  /// not seen there either. Empty if nothing is drawn. Worked out once, as above.
  const cv::Mat& DepthAndContours(ObjectId object, ObjectId support = {}) const;

 private:
  RenderedMaps maps_;
  mutable std::map<std::pair<ObjectId, ObjectId>, cv::Mat> depth_before_, depth_and_contours_;
};

/// Draws mean states, at half the image's size and on the processor, to learn who hides whom. One
/// thread at a time.
class OcclusionRenderer {
 public:
  explicit OcclusionRenderer(const ModelDatabase& database);

  /// Depth and id of the nearest object of every pixel.
  RenderedMaps Render(const PinholeCamera& camera, const Eigen::Isometry3d& cam_from_world,
                      std::span<const PlacedModel> objects);
  OcclusionMaps RenderOccluders(const PinholeCamera& camera,
                                const Eigen::Isometry3d& cam_from_world,
                                std::span<const PlacedModel> objects);
  /// Those that may show; the others change nothing of what is drawn.
  std::vector<PlacedModel> InView(const PinholeCamera& camera,
                                  const Eigen::Isometry3d& cam_from_world,
                                  std::span<const PlacedModel> objects) const;

 private:
  RenderedMaps Draw(const PinholeCamera& camera, const Eigen::Isometry3d& cam_from_world,
                    std::span<const PlacedModel> objects, bool contour_and_second_layer);
  std::unique_ptr<Renderer> renderer_;
  std::vector<int> mesh_of_model_;
  std::vector<Eigen::AlignedBox3f> bounds_of_model_;
};

}  // namespace plumbline
