// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <Eigen/Core>

#include "engine/dataset/sequence.h"

namespace plumbline {

struct EdgeAgreementOptions {
  double search_px = 8;  ///< Along the normal, each way, in an image 640 wide (in proportion).
  double sigma_px = 2;   ///< An edge at distance d counts exp(-d^2 / (2 sigma^2)); likewise.
  double min_agreement = 0.9;         ///< |cos| between the line's normal and the edge's.
  double certain_probability = 0.25;  ///< An edge of this probability or more counts in full.
  double crease_weight = 0.5;         ///< Of a length of crease beside the same length of contour.
};

/// The image's edge that a sample of the outline meets.
struct EdgeHit {
  float offset_px = 0;  ///< From the sample along its normal.
  float strength = 0;   ///< 0 .. 1, less the farther; 0: there is no edge in reach.
};

/// Looks for edges along normals. `edges` must outlive it; safe to use from several threads.
class EdgeSearch {
 public:
  EdgeSearch(const EdgeMap& edges, const EdgeAgreementOptions& options);

  /// The edge of agreeing direction that counts most.
  EdgeHit Find(const Eigen::Vector2f& pixel, const Eigen::Vector2f& normal) const;
  /// Mean strength that a line anywhere in the image would find.
  double Chance() const;

 private:
  void Consider(int x, int y, const Eigen::Vector2f& pixel, const Eigen::Vector2f& normal,
                EdgeHit& best) const;

  const EdgeMap& edges_;
  float reach_px_, sigma_px_, min_agreement_;
  std::array<float, 256> strength_;  ///< By probability.
};

}  // namespace plumbline
