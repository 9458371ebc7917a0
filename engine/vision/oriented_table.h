// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "engine/dataset/sequence.h"

namespace plumbline {

/// How a hit counts less with its distance k from the contour.
enum class HitProfile {
  kGaussian,  ///< exp(-k^2 / (2 sigma^2))
  kFlat,      ///< Not at all: whether there is an edge.
  kLinear     ///< 1 - k / (radius + 1): how far the nearest of equally strong edges is.
};

struct OrientedTableOptions {
  double radius_px = 12;       ///< Length of the search along the contour's normal, each way.
  double sigma_px = 5;         ///< A hit at distance k counts exp(-k^2 / (2 sigma^2)).
  double power = 2.0;          ///< A hit counts probability^power: faint edges are mostly clutter.
  double min_agreement = 0.9;  ///< |cos| of the angle between contour normal and edge normal.
  HitProfile profile = HitProfile::kGaussian;
};

/// One-dimensional search along contour normals, tabulated once for a frame: for every pixel and
/// direction of the normal, the best hit, max over offsets k of probability(x + k n)^power exp(-k^2
/// / (2 sigma^2)) among edges of agreeing orientation. A contour sample then costs one look-up.
/// Immutable; share it.
class OrientedTable {
 public:
  static constexpr int kBins = 16;

  OrientedTable(const EdgeMap& edges, const OrientedTableOptions& options);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Best hit in 0 .. 255 at pixel (x, y) for normals in [bin, bin + 1) * pi / kBins (centres at
  /// bin + 0.5). The pixel must be inside.
  std::uint8_t Hit(int x, int y, int bin) const {
    return hits_[(static_cast<std::size_t>(bin) * height_ + y) * width_ + x];
  }
  /// All hits: that of pixel (x, y) and a bin is at (bin * height + y) * width + x.
  const std::uint8_t* cells() const { return hits_.data(); }
  /// The hits pixel by pixel, row by row: kBins of each.
  std::vector<std::uint8_t> Interleaved() const;
  /// Mean hit over all pixels and bins, in [0, 1]: what a contour scores by chance.
  double chance() const { return chance_; }

 private:
  int width_, height_;
  std::vector<std::uint8_t> hits_;  ///< A plane for each bin.
  double chance_ = 0;
};

/// Edges at half size, rounded up as PinholeCamera::Scaled does: the strongest of four pixels. A
/// table of them searches twice as far.
EdgeMap HalfSize(const EdgeMap& edges);

}  // namespace plumbline
