// SPDX-License-Identifier: Apache-2.0
#include "tests/support/scoring_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"

namespace plumbline {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

void SetEdge(const cv::Point& at, double angle, int probability, EdgeMap& edges) {
  if (!cv::Rect(0, 0, edges.probability.cols, edges.probability.rows).contains(at)) return;
  edges.probability.at<uchar>(at) = static_cast<uchar>(probability);
  edges.angle.at<uchar>(at) = static_cast<uchar>(
      static_cast<int>(std::floor(angle * 256 / std::numbers::pi + 256.5)) & 255);
}

Eigen::Isometry3d LookingAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  world_from_cam.linear() << right, forward.cross(right), forward;
  world_from_cam.translation() = eye;
  return world_from_cam.inverse();
}

EdgeMap EdgesOf(const RenderedMaps& maps, Random& random) {
  const cv::Size size = maps.depth.size();
  cv::Mat shade = maps.depth.clone(), dx, dy;
  shade.setTo(4.5, maps.depth == 0);
  cv::GaussianBlur(shade, shade, {}, 1.0);
  cv::Sobel(shade, dx, CV_32F, 1, 0);
  cv::Sobel(shade, dy, CV_32F, 0, 1);
  EdgeMap edges;
  edges.probability = cv::Mat(size, CV_8U, cv::Scalar(0));
  edges.angle = edges.probability.clone();
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const bool dropped = (x / 24 * 7 + y / 24 * 13) % 3 == 0;
      if (maps.contour.at<uchar>(y, x) == 0 || dropped) continue;
      const cv::Point jittered(static_cast<int>(std::lround(x + 0.6 * random.Gaussian())),
                               static_cast<int>(std::lround(y + 0.6 * random.Gaussian())));
      SetEdge(jittered, std::atan2(dy.at<float>(y, x), dx.at<float>(y, x)), 220, edges);
    }
  }
  for (int line = 0; line < 30; ++line) {
    const double angle = std::numbers::pi * random.Uniform();
    const cv::Point2d from(size.width * random.Uniform(), size.height * random.Uniform());
    for (int k = 0; k < 60; ++k) {
      SetEdge(cv::Point(from + k * cv::Point2d(-std::sin(angle), std::cos(angle))), angle, 180,
              edges);
    }
  }
  return edges;
}

}  // namespace

ScoringView ScoringScene::View() const {
  ScoringView view;
  view.camera = camera;
  view.cam_from_world = cam_from_world;
  view.table = table.get();
  view.occluder_depth = occluder_depth;
  return view;
}

Eigen::Isometry3d CamFromObject(const ScoringScene& scene, const ModelDatabase& database,
                                const PoseHypothesis& hypothesis) {
  const UprightFrame upright(Eigen::Vector3d(0, 0, -1));
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
  world_from_object.linear() = upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
  world_from_object.translation() =
      hypothesis.center_in_world -
      world_from_object.linear() * database.model(hypothesis.label).center();
  return scene.cam_from_world * world_from_object;
}

ScoringScene MakeScoringScene(Renderer& renderer, const ModelDatabase& database, ModelId model,
                              const PinholeCamera& camera, std::uint64_t seed) {
  Random random({.seed = seed});
  ScoringScene scene;
  scene.camera = camera;
  const double distance = 2.0 + random.Uniform();
  scene.truth = {model,
                 2 * std::numbers::pi * random.Uniform(),
                 {distance, 0.3 * random.Gaussian(), database.model(model).center().z()}};
  scene.cam_from_world = LookingAt({0, 0, 1.5}, {2.5, 0.2 * random.Gaussian(), 0.5});
  const RenderInstance instance{renderer.AddMesh(database.model(model).mesh),
                                CamFromObject(scene, database, scene.truth), 1};
  RenderOptions options;
  options.contour = true;
  RenderedMaps maps = renderer.Render(camera, std::span(&instance, 1), options);
  if (seed % 2 == 1) {
    scene.occluder_depth = cv::Mat(camera.height / 2, camera.width / 2, CV_32F, cv::Scalar(0));
    const cv::Rect box = cv::boundingRect(maps.id > 0);
    const cv::Rect board(box.x, box.y + box.height / 2, box.width / 2, box.height / 2);
    maps.contour(board).setTo(0);
    cv::Mat hidden =
        scene.occluder_depth(cv::Rect(board.x / 2, board.y / 2, board.width / 2, board.height / 2));
    hidden.setTo(1.0);
  }
  scene.table = std::make_unique<OrientedTable>(EdgesOf(maps, random), OrientedTableOptions{});
  return scene;
}

std::vector<PoseHypothesis> Scattered(const ScoringScene& scene, int count, double position_m,
                                      double angle_deg, std::uint64_t seed) {
  Random random({.seed = seed});
  std::vector<PoseHypothesis> hypotheses;
  for (int i = 0; i < count; ++i) {
    PoseHypothesis hypothesis = scene.truth;
    hypothesis.azimuth_rad += angle_deg * kDegree * random.Gaussian();
    hypothesis.center_in_world +=
        position_m * Eigen::Vector3d(random.Gaussian(), random.Gaussian(), random.Gaussian());
    hypotheses.push_back(hypothesis);
  }
  return hypotheses;
}

double Spearman(const std::vector<double>& a, const std::vector<double>& b) {
  const auto ranks = [](const std::vector<double>& values) {
    std::vector<std::size_t> order(values.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return values[i] < values[j]; });
    std::vector<double> rank(values.size());
    for (std::size_t i = 0; i < order.size(); ++i) rank[order[i]] = static_cast<double>(i);
    return rank;
  };
  const std::vector<double> x = ranks(a), y = ranks(b);
  const double mean = 0.5 * static_cast<double>(x.size() - 1);
  double xy = 0, xx = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xy += (x[i] - mean) * (y[i] - mean);
    xx += (x[i] - mean) * (x[i] - mean);
  }
  return xy / xx;
}

}  // namespace plumbline
