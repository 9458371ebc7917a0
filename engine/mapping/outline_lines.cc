// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/outline_lines.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace plumbline {
namespace {

constexpr int kLinesDirections = 8;
constexpr double kLinesFirst_rad = 0.3, kLinesFromAbove_rad = 20 * std::numbers::pi / 180;
constexpr double kLinesDistance = 3;  ///< In diagonals of the bounds.
const PinholeCamera kLinesCamera{640, 480, 500, 500, 319.5, 239.5};

}  // namespace

double OutlineLines(const HypothesisScorer& scorer, const ModelDatabase& database, ModelId label) {
  EdgeMap no_edges;
  no_edges.probability = cv::Mat::zeros(kLinesCamera.height, kLinesCamera.width, CV_8U);
  no_edges.angle = cv::Mat::zeros(kLinesCamera.height, kLinesCamera.width, CV_8U);
  const OrientedTable table(no_edges, {});
  const UprightFrame upright({0, 0, -1});  // any: the same for every map
  const double distance = kLinesDistance * database.model(label).bounds.sizes().norm();
  const Eigen::Matrix3d world_from_level = upright.WorldFromObjectRotation(0);
  Eigen::Isometry3d world_from_cam = Eigen::Isometry3d::Identity();
  world_from_cam.linear().col(0) = world_from_level * -Eigen::Vector3d::UnitY();
  world_from_cam.linear().col(2) =
      world_from_level *
      Eigen::Vector3d(std::cos(kLinesFromAbove_rad), 0, -std::sin(kLinesFromAbove_rad));
  world_from_cam.linear().col(1) =
      world_from_cam.linear().col(2).cross(world_from_cam.linear().col(0));
  world_from_cam.translation() = -distance * world_from_cam.linear().col(2);
  ScoringView view;
  view.camera = kLinesCamera;
  view.cam_from_world = world_from_cam.inverse();
  view.table = &table;
  double sum = 0;
  for (int i = 0; i < kLinesDirections; ++i) {
    const PoseHypothesis seen{
        label, kLinesFirst_rad + 2 * std::numbers::pi * i / kLinesDirections, {0, 0, 0}};
    HypothesisScore score;
    scorer.Score(view, upright, {&seen, 1}, {&score, 1});
    const Box2& box = score.whole_box;
    const double perimeter_m = 2 * (box.x1 - box.x0 + box.y1 - box.y0) * distance / kLinesCamera.fx;
    sum += perimeter_m > 0 ? score.total_m / perimeter_m : 1;
  }
  return std::max(1.0, sum / kLinesDirections);
}

}  // namespace plumbline
