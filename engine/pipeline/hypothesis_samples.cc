// SPDX-License-Identifier: Apache-2.0
// The contour of one hypothesis in the image: its samples and the edges that they find.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/pipeline/hypothesis_frame.h"

namespace plumbline {
namespace {

/// The edge that gives the best hit along the normal, as the search table counts it.
std::optional<float> BestEdge(const EdgeMap& edges, const OrientedTableOptions& options,
                              const Eigen::Vector2f& pixel, const Eigen::Vector2f& normal) {
  std::optional<float> best_at;
  double best = 0;
  const int radius = static_cast<int>(options.radius_px);
  for (int k = -radius; k <= radius; ++k) {
    const int x = static_cast<int>(std::lround(pixel.x() + static_cast<float>(k) * normal.x()));
    const int y = static_cast<int>(std::lround(pixel.y() + static_cast<float>(k) * normal.y()));
    if (x < 0 || y < 0 || x >= edges.probability.cols || y >= edges.probability.rows) continue;
    const double probability = edges.probability.at<std::uint8_t>(y, x) / 255.0;
    if (probability == 0) continue;
    const double angle = edges.angle.at<std::uint8_t>(y, x) * std::numbers::pi / 256;
    const double agreement = std::abs(std::cos(angle) * normal.x() + std::sin(angle) * normal.y());
    if (agreement < options.min_agreement) continue;
    const double hit = std::pow(probability, options.power) *
                       std::exp(-0.5 * k * k / (options.sigma_px * options.sigma_px));
    if (hit <= best) continue;
    best = hit;
    best_at = static_cast<float>(k);
  }
  return best_at;
}

}  // namespace

std::vector<ContourSample> HypothesisProbe::Samples(const Frame& frame,
                                                    const PoseHypothesis& hypothesis,
                                                    const EdgeMap& edges) const {
  const auto& model = viewpoints_[static_cast<std::size_t>(hypothesis.label.value)];
  const Eigen::Vector3d center = database_->model(hypothesis.label).center();
  const Eigen::Matrix3d world_from_object =
      frame.map.upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
  const Eigen::Isometry3d& cam_from_world = frame.view.cam_from_world;
  const Eigen::Vector3d camera_in_object =
      world_from_object.transpose() *
          (cam_from_world.inverse().translation() - hypothesis.center_in_world) /
          hypothesis.scale() +
      center;
  const ContourView contour = model->View(camera_in_object.cast<float>());
  const Eigen::Matrix3d linear = hypothesis.scale() * (cam_from_world.linear() * world_from_object);
  const Eigen::Vector3d translation = cam_from_world * hypothesis.center_in_world - linear * center;
  const OrientedTableOptions table_options = SearchOptions(options_, camera_.fx);
  const cv::Mat& occluder = frame.view.occluder_depth;
  std::vector<ContourSample> samples;
  for (int i = 0; i < contour.size; ++i) {
    const Eigen::Vector3d p =
        linear * Eigen::Vector3d(contour.x[i], contour.y[i], contour.z[i]) + translation;
    if (p.z() < frame.view.near_m) continue;
    const Eigen::Vector3d n = linear * Eigen::Vector3d(contour.nx[i], contour.ny[i], contour.nz[i]);
    const double bx = p.x() / p.z(), by = p.y() / p.z();
    ContourSample sample;
    sample.pixel =
        Eigen::Vector2d(camera_.fx * bx + camera_.cx, camera_.fy * by + camera_.cy).cast<float>();
    const Eigen::Vector2d outwards(camera_.fx * (n.x() - n.z() * bx),
                                   camera_.fy * (n.y() - n.z() * by));
    sample.normal = outwards.normalized().cast<float>();
    const int x = static_cast<int>(std::floor(sample.pixel.x() + 0.5f));
    const int y = static_cast<int>(std::floor(sample.pixel.y() + 0.5f));
    if (x < 0 || y < 0 || x >= table_->width() || y >= table_->height()) continue;
    sample.visible = true;
    if (!occluder.empty()) {
      const float in_front = occluder.at<float>(y * occluder.rows / table_->height(),
                                                x * occluder.cols / table_->width());
      sample.visible = !(in_front > 0 && in_front < p.z() - frame.view.occlusion_margin_m);
    }
    double turn = std::atan2(sample.normal.y(), sample.normal.x()) / std::numbers::pi;
    turn -= std::floor(turn);
    const int bin =
        std::min(OrientedTable::kBins - 1, static_cast<int>(turn * OrientedTable::kBins));
    sample.hit = static_cast<float>(table_->Hit(x, y, bin)) / 255.0f;
    if (frame.view.rims && i < contour.outline_size && contour.rim[i] > 0) {
      const Eigen::Vector2f inwards = (-contour.rim[i] / p.z() * outwards).cast<float>();
      const Eigen::Vector2f along = sample.pixel + inwards;
      const int u = static_cast<int>(std::floor(along.x() + 0.5f)),
                v = static_cast<int>(std::floor(along.y() + 0.5f));
      if (u >= 0 && v >= 0 && u < table_->width() && v < table_->height()) {
        sample.hit = std::max(sample.hit, RimWeight(inwards.norm()) *
                                              static_cast<float>(table_->Hit(u, v, bin)) / 255.0f);
      }
    }
    sample.edge_at_px = BestEdge(edges, table_options, sample.pixel, sample.normal);
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace plumbline
