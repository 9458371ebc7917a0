// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/edge_claims.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

constexpr float kUnclaimed = 0.05f;  ///< Of what nobody in the map may have drawn.
constexpr int kReach_px = 1;         ///< An edge is one pixel wide, its neighbours are its own.

}  // namespace

std::vector<EdgeClaim> ClaimsOf(const ImageCheck& check, cv::Size image) {
  std::vector<EdgeClaim> claims;
  for (std::size_t i = 0; i < check.hits.size(); ++i) {
    const EdgeHit& hit = check.hits[i];
    const OutlineSample& sample = check.outline.samples[i];
    if (hit.strength <= 0 || sample.hidden) continue;
    const Eigen::Vector2f middle = sample.pixel + hit.offset_px * sample.normal;
    const Eigen::Vector2f along(-sample.normal.y(), sample.normal.x());
    const int half = static_cast<int>(std::ceil(sample.length_px / 2));
    for (int k = -half; k <= half; ++k) {
      const Eigen::Vector2f at = middle + static_cast<float>(k) * along;
      const int x = static_cast<int>(std::lround(at.x())),
                y = static_cast<int>(std::lround(at.y()));
      for (int v = std::max(0, y - kReach_px); v <= std::min(image.height - 1, y + kReach_px);
           ++v) {
        for (int u = std::max(0, x - kReach_px); u <= std::min(image.width - 1, x + kReach_px); ++u)
          claims.push_back({v * image.width + u, hit.strength});
      }
    }
  }
  std::sort(claims.begin(), claims.end(), [](const EdgeClaim& a, const EdgeClaim& b) {
    return a.pixel != b.pixel ? a.pixel < b.pixel : a.strength > b.strength;
  });
  claims.erase(
      std::unique(claims.begin(), claims.end(),
                  [](const EdgeClaim& a, const EdgeClaim& b) { return a.pixel == b.pixel; }),
      claims.end());
  return claims;
}

EdgeMap ShareOf(const EdgeMap& edges, std::span<const EdgeClaim> own,
                std::span<const std::vector<EdgeClaim>* const> others) {
  cv::Mat of_others = cv::Mat::zeros(edges.probability.size(), CV_32F);
  for (const std::vector<EdgeClaim>* claims : others) {
    for (const EdgeClaim& claim : *claims) of_others.ptr<float>()[claim.pixel] += claim.strength;
  }
  cv::Mat of_own(edges.probability.size(), CV_32F, cv::Scalar(kUnclaimed));
  for (const EdgeClaim& claim : own) of_own.ptr<float>()[claim.pixel] += claim.strength;
  EdgeMap left{edges.probability.clone(), edges.angle};
  for (int y = 0; y < left.probability.rows; ++y) {
    auto* probability = left.probability.ptr<std::uint8_t>(y);
    const auto* mine = of_own.ptr<float>(y);
    const auto* theirs = of_others.ptr<float>(y);
    for (int x = 0; x < left.probability.cols; ++x) {
      if (probability[x] == 0 || theirs[x] == 0) continue;
      probability[x] = static_cast<std::uint8_t>(
          std::lround(static_cast<float>(probability[x]) * mine[x] / (mine[x] + theirs[x])));
    }
  }
  return left;
}

}  // namespace plumbline
