// SPDX-License-Identifier: Apache-2.0
#include "tests/support/scoring_scene.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "engine/geometry/random_vector.h"
#include "engine/vision/edge_gradient.h"
#include "engine/vision/model_lines.h"

namespace plumbline {
namespace {

Eigen::Isometry3d LookingAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target) {
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  world_from_cam.linear() << right, forward.cross(right), forward;
  world_from_cam.translation() = eye;
  return world_from_cam.inverse();
}

/// A picture of the object before a wall, by rays: nothing that the scorers share. Two lamps, noise
/// of a camera, a blurred pixel, and 30 strokes of clutter.
struct Picture {
  cv::Mat image;  ///< CV_8UC3 BGR
  cv::Rect object;
};

Picture Photograph(const TriangleMesh& mesh, const PinholeCamera& camera,
                   const Eigen::Isometry3d& cam_from_object, Random& random) {
  const RayScene scene(mesh);
  const Eigen::Matrix3f object_from_cam = cam_from_object.linear().transpose().cast<float>().eval();
  const Eigen::Vector3f origin = cam_from_object.inverse().translation().cast<float>();
  const Eigen::Vector3f lamps[] = {object_from_cam * Eigen::Vector3f(0.5f, -0.7f, -0.5f),
                                   object_from_cam * Eigen::Vector3f(-0.8f, -0.1f, -0.6f)};
  constexpr int kSide = 3;  // rays along each side of a pixel
  cv::Mat shade(camera.height, camera.width, CV_32F);
  cv::Mat hit(shade.size(), CV_8U, cv::Scalar(0));
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x) {
      float sum = 0;
      for (int k = 0; k < kSide * kSide; ++k) {
        const double u = x + (k % kSide + 0.5) / kSide - 0.5,
                     v = y + (k / kSide + 0.5) / kSide - 0.5;
        const Eigen::Vector3f direction =
            object_from_cam * Eigen::Vector3f(static_cast<float>((u - camera.cx) / camera.fx),
                                              static_cast<float>((v - camera.cy) / camera.fy), 1);
        const RayScene::Hit at = scene.Cast(origin, direction);
        if (at.distance <= 0) {
          sum += 150 - 0.05f * static_cast<float>(y);
          continue;
        }
        hit.at<uchar>(y, x) = 255;
        Eigen::Vector3f normal = at.normal.normalized();
        if (normal.dot(direction) > 0) normal = -normal;
        sum += 40 + 70 * std::max(0.0f, normal.dot(lamps[0])) +
               35 * std::max(0.0f, normal.dot(lamps[1]));
      }
      shade.at<float>(y, x) = sum / (kSide * kSide);
    }
  }
  for (int stroke = 0; stroke < 30; ++stroke) {
    const double angle = std::numbers::pi * random.Uniform();
    const double y = camera.height * random.Uniform(), x = camera.width * random.Uniform();
    const cv::Point2d from(x, y);
    cv::line(shade, cv::Point(from),
             cv::Point(from + 60 * cv::Point2d(-std::sin(angle), std::cos(angle))),
             cv::Scalar(60 + 140 * random.Uniform()), 3, cv::LINE_AA);
  }
  cv::GaussianBlur(shade, shade, {}, 0.7);
  for (int y = 0; y < shade.rows; ++y) {
    for (int x = 0; x < shade.cols; ++x)
      shade.at<float>(y, x) += 2.0f * static_cast<float>(random.Gaussian());
  }
  Picture picture;
  shade.convertTo(picture.image, CV_8U);
  cv::cvtColor(picture.image, picture.image, cv::COLOR_GRAY2BGR);
  picture.object = cv::boundingRect(hit);
  return picture;
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

ScoringScene MakeScoringScene(const ModelDatabase& database, ModelId model,
                              const PinholeCamera& camera, std::uint64_t seed) {
  Random random({.seed = seed});
  ScoringScene scene;
  scene.camera = camera;
  const double distance = 2.0 + random.Uniform();
  scene.truth = {model,
                 2 * std::numbers::pi * random.Uniform(),
                 {distance, 0.3 * random.Gaussian(), database.model(model).center().z()}};
  scene.cam_from_world = LookingAt({0, 0, 1.5}, {2.5, 0.2 * random.Gaussian(), 0.5});
  Picture picture = Photograph(database.model(model).mesh, camera,
                               CamFromObject(scene, database, scene.truth), random);
  if (seed % 2 == 1) {
    const cv::Rect box = picture.object;
    const cv::Rect board(box.x, box.y + box.height / 2, box.width / 2, box.height / 2);
    picture.image(board).setTo(cv::Scalar::all(90));
    scene.occluder_depth = cv::Mat(camera.height / 2, camera.width / 2, CV_32F, cv::Scalar(0));
    cv::Mat hidden =
        scene.occluder_depth(cv::Rect(board.x / 2, board.y / 2, board.width / 2, board.height / 2));
    hidden.setTo(1.0);
  }
  Frame frame;
  frame.image = picture.image;
  const EdgeMap edges = CreateGradientEdgeDetector()->Detect(frame).value();
  scene.table = std::make_unique<OrientedTable>(edges, OrientedTableOptions{});
  return scene;
}

std::vector<PoseHypothesis> Scattered(const ScoringScene& scene, int count, double position_m,
                                      double angle_deg, std::uint64_t seed) {
  Random random({.seed = seed});
  std::vector<PoseHypothesis> hypotheses;
  for (int i = 0; i < count; ++i) {
    PoseHypothesis hypothesis = scene.truth;
    hypothesis.azimuth_rad += angle_deg * kRadPerDeg * random.Gaussian();
    hypothesis.center_in_world += position_m * GaussianVector<3>(random);
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
