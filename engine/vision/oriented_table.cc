// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/oriented_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/base/check.h"

namespace plumbline {
namespace {

/// A step along a bin's normal: the pixels it covers and how much a hit there counts.
struct Offset {
  int dx, dy;
  int weight;  ///< 0 .. 256
};

/// The line through the origin along a normal, two pixels wide across its minor axis so that the
/// lines of neighbouring edge pixels leave no holes between them.
std::vector<Offset> LineOffsets(double angle, const OrientedTableOptions& options) {
  const double nx = std::cos(angle), ny = std::sin(angle);
  const bool along_x = std::abs(nx) >= std::abs(ny);
  const double major = along_x ? nx : ny, minor = along_x ? ny : nx;
  std::vector<Offset> line;
  const int steps = static_cast<int>(std::floor(options.radius_px * std::abs(major)));
  for (int i = -steps; i <= steps; ++i) {
    const double k = i / major;
    const double exact = k * minor;
    const int weight = static_cast<int>(
        std::lround(256.0 * std::exp(-k * k / (2.0 * options.sigma_px * options.sigma_px))));
    const int low = static_cast<int>(std::floor(exact));
    for (int m = low; m <= low + (exact > low ? 1 : 0); ++m) {
      line.push_back(along_x ? Offset{i, m, weight} : Offset{m, i, weight});
    }
  }
  return line;
}

}  // namespace

OrientedTable::OrientedTable(const EdgeMap& edges, const OrientedTableOptions& options)
    : width_(edges.probability.cols), height_(edges.probability.rows) {
  PLB_CHECK(edges.probability.type() == CV_8U && edges.angle.type() == CV_8U &&
            edges.probability.size() == edges.angle.size())
      << "edge maps are 8-bit and of one size";
  hits_.assign(static_cast<std::size_t>(width_) * height_ * kBins, 0);
  std::vector<Offset> lines[kBins];
  std::vector<int> bins_of_angle[256];
  for (int bin = 0; bin < kBins; ++bin) {
    const double angle = (bin + 0.5) * std::numbers::pi / kBins;
    lines[bin] = LineOffsets(angle, options);
    for (int a = 0; a < 256; ++a) {
      if (std::abs(std::cos(angle - a * std::numbers::pi / 256)) > options.min_agreement)
        bins_of_angle[a].push_back(bin);
    }
  }
  int strength[256];
  for (int p = 0; p < 256; ++p)
    strength[p] = static_cast<int>(std::lround(255.0 * std::pow(p / 255.0, options.power)));
  const int margin = static_cast<int>(std::ceil(options.radius_px)) + 1;
  for (int y = 0; y < height_; ++y) {
    const auto* probability = edges.probability.ptr<std::uint8_t>(y);
    const auto* angle = edges.angle.ptr<std::uint8_t>(y);
    for (int x = 0; x < width_; ++x) {
      const int p = strength[probability[x]];
      if (p < 4) continue;
      const bool inner = x >= margin && y >= margin && x < width_ - margin && y < height_ - margin;
      for (const int bin : bins_of_angle[angle[x]]) {
        for (const Offset& offset : lines[bin]) {
          const int px = x + offset.dx, py = y + offset.dy;
          if (!inner && (px < 0 || py < 0 || px >= width_ || py >= height_)) continue;
          std::uint8_t& hit = hits_[(static_cast<std::size_t>(py) * width_ + px) * kBins + bin];
          hit = std::max(hit, static_cast<std::uint8_t>(p * offset.weight >> 8));
        }
      }
    }
  }
  std::uint64_t sum = 0;
  for (const std::uint8_t hit : hits_) sum += hit;
  chance_ =
      hits_.empty() ? 0.0 : static_cast<double>(sum) / (255.0 * static_cast<double>(hits_.size()));
}

}  // namespace plumbline
