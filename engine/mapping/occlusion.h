// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <span>
#include <tuple>
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

/// Whose contours are left out of an image: all others', or those of what need not stand on the
/// floor.
enum class ContoursOf { kAllOthers, kRaisedThings };

/// What stands before each object in one image.
class OcclusionMaps {
 public:
  OcclusionMaps() = default;
  /// @param raised  Ids of what need not stand on the floor.
  explicit OcclusionMaps(RenderedMaps maps, std::vector<ObjectId> raised = {})
      : maps_(std::move(maps)), raised_(std::move(raised)) {}

  /// With contour, and with a second layer where there is one.
  const RenderedMaps& rendered() const { return maps_; }
  /// Z [m] of the nearest surface that is neither the object's own nor that of what it stands on,
  /// if anything; 0 none. Empty if nothing is drawn. Worked out once for each object: not for two
  /// threads at a time.
  const cv::Mat& DepthBefore(ObjectId object, ObjectId support = {}) const;
  /// The same, and next to nothing along the contours of others: whatever is scored with it is not
  /// seen there either. Empty if nothing is drawn. Worked out once, as above.
  const cv::Mat& DepthAndContours(ObjectId object, ObjectId support = {},
                                  ContoursOf others = ContoursOf::kAllOthers) const;
  /// Luminance, 0 .. 1, of the nearest surface that is not the object's own: what its outline would
  /// be seen before; kNothingBehind where nothing is known. Empty if nothing is drawn. Worked out
  /// once, as above.
  const cv::Mat& LuminanceBehind(ObjectId object) const;
  static constexpr float kNothingBehind = 3;  ///< Differs from what is, and from what is unknown.

 private:
  RenderedMaps maps_;
  std::vector<ObjectId> raised_;
  mutable std::map<std::pair<ObjectId, ObjectId>, cv::Mat> depth_before_;
  mutable std::map<std::tuple<ObjectId, ObjectId, ContoursOf>, cv::Mat> depth_and_contours_;
  mutable std::map<ObjectId, cv::Mat> luminance_behind_;
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
  std::vector<Support> support_of_model_;
  std::vector<Eigen::AlignedBox3f> bounds_of_model_;
};

}  // namespace plumbline
