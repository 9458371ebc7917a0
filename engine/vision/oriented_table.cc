// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/oriented_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include <tbb/parallel_for.h>

#include "engine/base/check.h"

namespace plumbline {
namespace {

constexpr int kFaintest = 4;

/// A step along a bin's normal: the pixels it covers and how much a hit there counts.
struct Offset {
  int dx, dy;
  int weight;  ///< 0 .. 256
};

/// Of a hit at distance k, in [0, 1].
double Weight(double k, const OrientedTableOptions& options) {
  switch (options.profile) {
    case HitProfile::kGaussian:
      return std::exp(-k * k / (2.0 * options.sigma_px * options.sigma_px));
    case HitProfile::kFlat:
      return 1;
    case HitProfile::kLinear:
      return 1 - std::abs(k) / (options.radius_px + 1);
  }
  return 0;
}

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
    const int weight = static_cast<int>(std::lround(256.0 * Weight(k, options)));
    const int low = static_cast<int>(std::floor(exact));
    for (int m = low; m <= low + (exact > low ? 1 : 0); ++m) {
      line.push_back(along_x ? Offset{i, m, weight} : Offset{m, i, weight});
    }
  }
  return line;
}

struct Edge {
  int x, y;
  int strength;  ///< 0 .. 255
  int angle;     ///< In 256ths of a half turn.
};

std::vector<Edge> ListEdges(const EdgeMap& edges, const OrientedTableOptions& options) {
  int strength[256];
  for (int p = 0; p < 256; ++p)
    strength[p] = static_cast<int>(std::lround(255.0 * std::pow(p / 255.0, options.power)));
  std::vector<Edge> list;
  for (int y = 0; y < edges.probability.rows; ++y) {
    const auto* probability = edges.probability.ptr<std::uint8_t>(y);
    const auto* angle = edges.angle.ptr<std::uint8_t>(y);
    for (int x = 0; x < edges.probability.cols; ++x) {
      if (strength[probability[x]] >= kFaintest)
        list.push_back({x, y, strength[probability[x]], angle[x]});
    }
  }
  return list;
}

/// Raises the hits along the normal's direction around every edge whose normal agrees with it.
void Scatter(const std::vector<Edge>& edges, double normal_rad, const OrientedTableOptions& options,
             const cv::Size& size, std::uint8_t* hits) {
  const std::vector<Offset> line = LineOffsets(normal_rad, options);
  bool agrees[256];
  for (int a = 0; a < 256; ++a) {
    agrees[a] = std::abs(std::cos(normal_rad - a * std::numbers::pi / 256)) > options.min_agreement;
  }
  std::vector<std::ptrdiff_t> steps;  // To the pixels of the line.
  for (const Offset& offset : line)
    steps.push_back(static_cast<std::ptrdiff_t>(offset.dy) * size.width + offset.dx);
  const int margin = static_cast<int>(std::ceil(options.radius_px)) + 1;
  for (const Edge& edge : edges) {
    if (!agrees[edge.angle]) continue;
    std::uint8_t* at = hits + static_cast<std::ptrdiff_t>(edge.y) * size.width + edge.x;
    const bool inner = edge.x >= margin && edge.y >= margin && edge.x < size.width - margin &&
                       edge.y < size.height - margin;
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (!inner) {
        const int x = edge.x + line[i].dx, y = edge.y + line[i].dy;
        if (x < 0 || y < 0 || x >= size.width || y >= size.height) continue;
      }
      std::uint8_t& hit = at[steps[i]];
      hit = std::max(hit, static_cast<std::uint8_t>(edge.strength * line[i].weight >> 8));
    }
  }
}

}  // namespace

OrientedTable::OrientedTable(const EdgeMap& edges, const OrientedTableOptions& options)
    : width_(edges.probability.cols), height_(edges.probability.rows) {
  PLB_CHECK(edges.probability.type() == CV_8U && edges.angle.type() == CV_8U &&
            edges.probability.size() == edges.angle.size())
      << "edge maps are 8-bit and of one size";
  const std::size_t plane = static_cast<std::size_t>(width_) * height_;
  hits_.assign(plane * kBins, 0);
  const std::vector<Edge> list = ListEdges(edges, options);
  std::uint64_t sums[kBins] = {};
  tbb::parallel_for(0, kBins, [&](int bin) {
    std::uint8_t* hits = hits_.data() + plane * bin;
    Scatter(list, (bin + 0.5) * std::numbers::pi / kBins, options, {width_, height_}, hits);
    for (int y = 0; y < height_; ++y) {
      const std::uint8_t* row = hits + static_cast<std::size_t>(y) * width_;
      sums[bin] += std::accumulate(row, row + width_, std::uint32_t{0});
    }
  });
  const std::uint64_t sum = std::accumulate(std::begin(sums), std::end(sums), std::uint64_t{0});
  chance_ =
      hits_.empty() ? 0.0 : static_cast<double>(sum) / (255.0 * static_cast<double>(hits_.size()));
}

std::vector<std::uint8_t> OrientedTable::Interleaved() const {
  const std::size_t plane = static_cast<std::size_t>(width_) * height_;
  std::vector<std::uint8_t> result(hits_.size());
  for (std::size_t pixel = 0; pixel < plane; ++pixel) {
    for (std::size_t bin = 0; bin < kBins; ++bin)
      result[pixel * kBins + bin] = hits_[bin * plane + pixel];
  }
  return result;
}

EdgeMap HalfSize(const EdgeMap& edges) {
  EdgeMap half;
  const cv::Size size = edges.probability.size();
  half.probability = cv::Mat((size.height + 1) / 2, (size.width + 1) / 2, CV_8U);
  half.angle = cv::Mat(half.probability.size(), CV_8U);
  for (int y = 0; y < half.probability.rows; ++y) {
    for (int x = 0; x < half.probability.cols; ++x) {
      int best = -1;
      for (int k = 0; k < 4; ++k) {
        const int sy = 2 * y + k / 2, sx = 2 * x + k % 2;
        if (sy >= size.height || sx >= size.width) continue;
        const int p = edges.probability.at<std::uint8_t>(sy, sx);
        if (p <= best) continue;
        best = p;
        half.probability.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(p);
        half.angle.at<std::uint8_t>(y, x) = edges.angle.at<std::uint8_t>(sy, sx);
      }
    }
  }
  return half;
}

}  // namespace plumbline
