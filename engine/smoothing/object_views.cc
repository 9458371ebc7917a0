// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/object_views.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace plumbline {
namespace {

constexpr double kFullyVisible = 0.5;   ///< More does not make a better view.
constexpr double kSameView_rad = 0.02;  ///< Nearer to another one, a view adds nothing.

double Difference(const ObjectSight& a, const ObjectSight& b) {
  const double angle = std::acos(std::clamp(a.from.dot(b.from), -1.0, 1.0));
  return angle + 0.5 * std::abs(std::log(a.distance_m / b.distance_m));
}

double Quality(const ObjectSight& sight) {
  return sight.steadiness * sight.telling * std::min(1.0, sight.visible_fraction / kFullyVisible);
}

/// An image without edges: what shows of a contour does not depend on them.
OrientedTable BlankTable(const PinholeCamera& camera) {
  EdgeMap edges;
  edges.probability = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  edges.angle = cv::Mat::zeros(camera.height, camera.width, CV_8U);
  return {edges, {}};
}

}  // namespace

double Telling(const HypothesisScore& score, double depth_m, const MapperOptions& options) {
  return std::min(1.0, score.visible_m * kFocalOfLengths_px / depth_m / options.telling_contour_px);
}

ScoringView ViewOf(const MapperSetup& setup, const Eigen::Isometry3d& world_from_cam,
                   const OcclusionMaps& maps, ObjectId object, const OrientedTable& table) {
  ScoringView view;
  view.camera = setup.camera;
  view.cam_from_world = world_from_cam.inverse();
  view.table = &table;
  view.occluder_depth = maps.DepthBefore(object);
  view.occlusion_margin_m = setup.options.occlusion_margin_m;
  view.luminance_behind = maps.LuminanceBehind(object);
  view.least_contrast = setup.options.least_contrast;
  view.inner_lines = setup.options.inner_lines;
  view.rims = true;
  return view;
}

std::vector<PlacedModel> MeanStates(std::span<const MapObject> objects, bool confirmed_only) {
  std::vector<PlacedModel> placed;
  for (const MapObject& object : objects) {
    if (confirmed_only && object.state != ObjectState::kConfirmed) continue;
    placed.push_back(
        {object.id, object.mean().label, object.mean().world_from_object, object.mean().scale});
  }
  return placed;
}

std::vector<std::vector<ObjectSight>> FindSights(const MapperSetup& setup,
                                                 OcclusionRenderer& renderer,
                                                 std::span<const Look> looks,
                                                 std::span<const MapObject> objects) {
  const MapFrame map = MapFrameOf(setup);
  const OrientedTable blank = BlankTable(setup.camera);
  const std::vector<PlacedModel> solid = MeanStates(objects, true);
  std::vector<std::vector<ObjectSight>> sights(objects.size());
  for (std::size_t k = 0; k < looks.size(); ++k) {
    const Eigen::Isometry3d& world_from_cam = looks[k].at.world_from_cam;
    const OcclusionMaps maps =
        renderer.RenderOccluders(setup.camera, world_from_cam.inverse(), solid);
    for (std::size_t i = 0; i < objects.size(); ++i) {
      const PoseHypothesis mean = ToHypothesis(objects[i].mean(), map);
      const Eigen::Vector3d to_camera = world_from_cam.translation() - mean.center_in_world;
      const double depth = (world_from_cam.inverse() * mean.center_in_world).z();
      if (depth <= 0) continue;
      HypothesisScore score;
      setup.scorer->Score(ViewOf(setup, world_from_cam, maps, objects[i].id, blank), map.upright,
                          {&mean, 1}, {&score, 1});
      if (score.total_m <= 0 || score.visible_m < kLeastSight * score.total_m) continue;
      sights[i].push_back({looks[k].at.frame, score.visible_m / score.total_m,
                           Telling(score, depth, setup.options), looks[k].steadiness,
                           to_camera.normalized(), to_camera.norm()});
    }
  }
  return sights;
}

std::vector<std::size_t> ChooseViews(std::span<const ObjectSight> sights, int count) {
  std::vector<std::size_t> chosen;
  std::vector<double> apart(sights.size(), 1.0);
  while (static_cast<int>(chosen.size()) < count) {
    std::size_t best = sights.size();
    for (std::size_t i = 0; i < sights.size(); ++i) {
      if (apart[i] < kSameView_rad) continue;
      if (best == sights.size() ||
          Quality(sights[i]) * apart[i] > Quality(sights[best]) * apart[best])
        best = i;
    }
    if (best == sights.size()) break;
    if (chosen.empty()) apart.assign(sights.size(), std::numeric_limits<double>::infinity());
    chosen.push_back(best);
    for (std::size_t i = 0; i < sights.size(); ++i)
      apart[i] = std::min(apart[i], Difference(sights[i], sights[best]));
  }
  return chosen;
}

}  // namespace plumbline
