// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/edge_search.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace plumbline {

EdgeSearch::EdgeSearch(const EdgeMap& edges, const EdgeAgreementOptions& options)
    : edges_(edges), min_agreement_(static_cast<float>(options.min_agreement)) {
  const double scale = edges.probability.cols / 640.0;
  reach_px_ = static_cast<float>(options.search_px * scale);
  sigma_px_ = static_cast<float>(options.sigma_px * scale);
  for (int p = 0; p < 256; ++p) {
    strength_[static_cast<std::size_t>(p)] =
        static_cast<float>(std::min(1.0, p / (255.0 * options.certain_probability)));
  }
}

EdgeHit EdgeSearch::Find(const Eigen::Vector2f& pixel, const Eigen::Vector2f& normal) const {
  const int steps = static_cast<int>(std::ceil(reach_px_));
  EdgeHit best;
  for (int i = -steps; i <= steps; ++i) {
    // Edges are one pixel wide: the two pixels that the line passes between, so that none of a
    // slanting edge is missed.
    const Eigen::Vector2f at = pixel + static_cast<float>(i) * normal;
    const bool flat = std::abs(normal.x()) > std::abs(normal.y());
    const int x = static_cast<int>(flat ? std::lround(at.x()) : std::floor(at.x()));
    const int y = static_cast<int>(flat ? std::floor(at.y()) : std::lround(at.y()));
    Consider(x, y, pixel, normal, best);
    Consider(flat ? x : x + 1, flat ? y + 1 : y, pixel, normal, best);
  }
  return best;
}

double EdgeSearch::Chance() const {
  constexpr int kAcross = 24, kDown = 16, kDirections = 2;
  double sum = 0;
  for (int i = 0; i < kAcross * kDown * kDirections; ++i) {
    const int cell = i / kDirections;
    const double angle = std::numbers::pi * (i % kDirections) / kDirections +
                         std::numbers::pi * (cell % 7) / (7 * kDirections);
    const Eigen::Vector2f pixel(
        static_cast<float>(edges_.probability.cols * (cell % kAcross + 0.5) / kAcross),
        static_cast<float>(edges_.probability.rows * (cell / kAcross + 0.5) / kDown));
    sum += Find(pixel, {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))})
               .strength;
  }
  return sum / (kAcross * kDown * kDirections);
}

void EdgeSearch::Consider(int x, int y, const Eigen::Vector2f& pixel, const Eigen::Vector2f& normal,
                          EdgeHit& best) const {
  if (x < 0 || y < 0 || x >= edges_.probability.cols || y >= edges_.probability.rows) return;
  const int probability = edges_.probability.at<std::uint8_t>(y, x);
  if (probability == 0) return;
  const float offset =
      normal.dot(Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - pixel);
  if (std::abs(offset) > reach_px_) return;
  const float strength = strength_[static_cast<std::size_t>(probability)] *
                         std::exp(-0.5f * offset * offset / (sigma_px_ * sigma_px_));
  if (strength <= best.strength) return;
  const float angle =
      edges_.angle.at<std::uint8_t>(y, x) * static_cast<float>(std::numbers::pi / 256);
  if (std::abs(normal.x() * std::cos(angle) + normal.y() * std::sin(angle)) < min_agreement_) {
    return;
  }
  best = {offset, strength};
}

}  // namespace plumbline
