// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "engine/mapping/key_frames.h"
#include "engine/mapping/viewpoint_scorer.h"

namespace plumbline {

/// The test furniture on a floor (z = 0, z up), and images of it as the mapper would be given them:
/// perfect edges and boxes. One for a whole test program.
class MappingScene {
 public:
  static MappingScene& Get();
  /// A scene of its own with another camera.
  explicit MappingScene(const PinholeCamera& camera);

  const std::shared_ptr<const ModelDatabase>& database() const { return map_.database; }
  /// A ViewpointScorer; the first call takes seconds.
  const std::shared_ptr<const HypothesisScorer>& scorer();
  const MapFrame& map() const { return map_; }
  const PinholeCamera& camera() const { return camera_; }
  OcclusionRenderer& renderer() { return *renderer_; }
  ModelId Label(std::string_view name) const;

  /// An upright object on the floor.
  PlacedModel Place(std::string_view name, double x, double y, double azimuth_deg,
                    int id = 1) const;
  PoseHypothesis Hypothesis(const PlacedModel& placed) const;

  /// Full size; with contour.
  RenderedMaps Draw(const Eigen::Isometry3d& world_from_cam, std::span<const PlacedModel> objects);
  EdgeMap Edges(const Eigen::Isometry3d& world_from_cam, std::span<const PlacedModel> objects);
  /// Boxes of what shows, score 0.8.
  std::vector<Detection> Boxes(const Eigen::Isometry3d& world_from_cam,
                               std::span<const PlacedModel> objects);
  MapperInput Input(int frame, const Eigen::Isometry3d& world_from_cam,
                    std::span<const PlacedModel> objects);

 private:
  MapFrame map_;
  PinholeCamera camera_;
  std::shared_ptr<const HypothesisScorer> scorer_;
  std::unique_ptr<RenderContext> context_;
  std::unique_ptr<Renderer> full_size_;
  std::vector<int> meshes_;
  std::unique_ptr<OcclusionRenderer> renderer_;
};

/// A camera at `from` that looks at `at`, world z up.
Eigen::Isometry3d LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& at);

/// Thin edges with the direction of their normal from a contour mask.
EdgeMap EdgesOfContour(const cv::Mat& contour);

}  // namespace plumbline
