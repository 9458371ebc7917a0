// SPDX-License-Identifier: Apache-2.0
#include "tests/support/mapping_scene.h"

#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

#include "engine/vision/detector.h"
#include "engine/vision/thinning.h"
#include "tests/support/furniture_models.h"

namespace plumbline {
namespace {

template <typename T>
T Must(Result<T> result) {
  if (!result.ok()) throw std::runtime_error(result.error().message);
  return std::move(result).value();
}

ViewpointModelOptions CoarseViews() {
  ViewpointModelOptions options;
  options.azimuths = 48;
  options.elevations = 6;
  options.min_elevation_deg = -5;
  options.max_elevation_deg = 60;
  options.distances = {2.0, 3.0, 5.0};
  options.image_px = 176;
  return options;
}

}  // namespace

Eigen::Isometry3d LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& at) {
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  Eigen::Matrix3d axes;
  axes.col(2) = (at - from).normalized();
  axes.col(0) = axes.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  world_from_cam.linear() = axes;
  world_from_cam.translation() = from;
  return world_from_cam;
}

EdgeMap EdgesOfContour(const cv::Mat& contour) {
  cv::Mat soft;
  contour.convertTo(soft, CV_32F, 1.0 / 255);
  EdgeMap edges = ThinRidges(soft, 0.5f, CalibrationCurve({}));
  edges.probability.setTo(255, edges.probability > 0);
  return edges;
}

MappingScene& MappingScene::Get() {
  static MappingScene scene({480, 360, 420, 420, 239.5, 179.5});
  return scene;
}

MappingScene::MappingScene(const PinholeCamera& camera)
    : map_{UprightFrame({0, 0, -9.81}), Eigen::Vector4d(0, 0, 1, 0), MakeFurnitureDatabase()},
      camera_(camera) {
  context_ = Must(RenderContext::CreateHeadless());
  full_size_ = Must(Renderer::Create(*context_));
  for (const CadModel& model : database()->models())
    meshes_.push_back(full_size_->AddMesh(model.mesh));
  renderer_ = std::make_unique<OcclusionRenderer>(*database());
}

const std::shared_ptr<const HypothesisScorer>& MappingScene::scorer() {
  if (scorer_ == nullptr) {
    std::vector<std::shared_ptr<const ViewpointModel>> views;
    for (const CadModel& model : database()->models())
      views.push_back(Must(ViewpointModel::Build(model, CoarseViews(), {})));
    scorer_ = std::make_shared<ViewpointScorer>(std::move(views), database());
  }
  return scorer_;
}

ModelId MappingScene::Label(std::string_view name) const { return database()->Find(name).value(); }

PlacedModel MappingScene::Place(std::string_view name, double x, double y, double azimuth_deg,
                                int id) const {
  PlacedModel placed;
  placed.object = ObjectId{id};
  placed.label = Label(name);
  placed.world_from_object.linear() =
      map_.upright.WorldFromObjectRotation(azimuth_deg * std::numbers::pi / 180);
  placed.world_from_object.translation() = Eigen::Vector3d(x, y, 0);
  return placed;
}

PoseHypothesis MappingScene::Hypothesis(const PlacedModel& placed) const {
  return {placed.label, map_.upright.Azimuth(placed.world_from_object.linear()),
          placed.world_from_object * (placed.scale * database()->model(placed.label).center()),
          std::log(placed.scale)};
}

RenderedMaps MappingScene::Draw(const Eigen::Isometry3d& world_from_cam,
                                std::span<const PlacedModel> objects) {
  std::vector<RenderInstance> instances;
  for (const PlacedModel& placed : objects) {
    instances.push_back({meshes_[static_cast<std::size_t>(placed.label.value)],
                         world_from_cam.inverse() * placed.world_from_object, placed.object.value,
                         placed.scale});
  }
  RenderOptions options;
  options.contour = true;
  return full_size_->Render(camera_, instances, options);
}

EdgeMap MappingScene::Edges(const Eigen::Isometry3d& world_from_cam,
                            std::span<const PlacedModel> objects) {
  return EdgesOfContour(Draw(world_from_cam, objects).contour);
}

std::vector<Detection> MappingScene::Boxes(const Eigen::Isometry3d& world_from_cam,
                                           std::span<const PlacedModel> objects) {
  const RenderedMaps maps = Draw(world_from_cam, objects);
  std::vector<Detection> boxes;
  for (const PlacedModel& placed : objects) {
    Box2 box{1e9f, 1e9f, -1e9f, -1e9f};
    for (int y = 0; y < maps.id.rows; ++y) {
      for (int x = 0; x < maps.id.cols; ++x) {
        if (maps.id.at<std::uint16_t>(y, x) != placed.object.value) continue;
        box = {std::min<float>(box.x0, x), std::min<float>(box.y0, y), std::max<float>(box.x1, x),
               std::max<float>(box.y1, y)};
      }
    }
    if (box.width() > 8 && box.height() > 8)
      boxes.push_back({box, database()->model(placed.label).category, 0.8f});
  }
  return boxes;
}

MapperInput MappingScene::Input(int frame, const Eigen::Isometry3d& world_from_cam,
                                std::span<const PlacedModel> objects) {
  MapperInput input;
  input.frame = frame;
  input.stamp_ns = 100'000'000LL * (frame + 1);
  input.world_from_cam = world_from_cam;
  input.edges = Edges(world_from_cam, objects);
  MakeTables({}, camera_.fx, input);
  input.detections = DetectionsFromProposals(Boxes(world_from_cam, objects));
  return input;
}

}  // namespace plumbline
