// SPDX-License-Identifier: Apache-2.0
// The contour of one hypothesis in the image: its samples and the edges that they find.

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
  std::vector<ContourSample> samples;
  for (const ContourPointFound& point :
       scorer_->PointsFound(frame.view, frame.map.upright, hypothesis)) {
    samples.push_back({point.pixel, point.outwards, point.seen, point.hit,
                       BestEdge(edges, frame.search, point.pixel, point.outwards)});
  }
  return samples;
}

}  // namespace plumbline
