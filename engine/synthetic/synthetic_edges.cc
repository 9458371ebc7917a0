// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/synthetic_edges.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"
#include "engine/geometry/angles.h"
#include "engine/synthetic/material.h"

namespace plumbline {
namespace {

struct EdgePoint {
  int x, y;
  cv::Point2f normal;
  float contrast;
  bool geometric;
};

cv::Vec3f BearingOf(const PinholeCamera& camera, int x, int y) {
  return {static_cast<float>((x - camera.cx) / camera.fx),
          static_cast<float>((y - camera.cy) / camera.fy), 1};
}

/// Depth that the plane through p (with its normal) has in the direction of q.
float PlaneDepth(float depth_p, const cv::Vec3f& normal_p, const cv::Vec3f& bearing_p,
                 const cv::Vec3f& bearing_q) {
  const float there = normal_p.dot(bearing_q);
  return std::abs(there) < 1e-3f ? 1e3f : depth_p * normal_p.dot(bearing_p) / there;
}

/// One pass of Zhang and Suen's thinning; true if a pixel was removed.
bool ThinOnce(cv::Mat& mask, int phase) {
  std::vector<cv::Point> removed;
  for (int y = 1; y + 1 < mask.rows; ++y) {
    const std::uint8_t* row = mask.ptr(y);
    for (int x = 1; x + 1 < mask.cols; ++x) {
      if (!row[x]) continue;
      const std::uint8_t *up = mask.ptr(y - 1), *down = mask.ptr(y + 1);
      const std::array<bool, 9> p = {up[x] > 0,       up[x + 1] > 0, row[x + 1] > 0,
                                     down[x + 1] > 0, down[x] > 0,   down[x - 1] > 0,
                                     row[x - 1] > 0,  up[x - 1] > 0, up[x] > 0};
      int neighbours = 0, changes = 0;
      for (int i = 0; i < 8; ++i) {
        neighbours += p[i];
        changes += !p[i] && p[i + 1];
      }
      if (neighbours < 2 || neighbours > 6 || changes != 1) continue;
      const bool keep = phase == 0 ? (p[0] && p[2] && p[4]) || (p[2] && p[4] && p[6])
                                   : (p[0] && p[2] && p[6]) || (p[0] && p[4] && p[6]);
      if (!keep) removed.emplace_back(x, y);
    }
  }
  for (const cv::Point& point : removed) mask.at<std::uint8_t>(point) = 0;
  return !removed.empty();
}

void Thin(cv::Mat& mask) {
  for (bool again = true; again;) {
    const bool first = ThinOnce(mask, 0);
    again = ThinOnce(mask, 1) || first;
  }
}

/// Strong boundaries in the picture: Canny on the smoothed luminance.
cv::Mat PictureEdges(const cv::Mat& luminance) {
  cv::Mat smooth, dx, dy, edges;
  cv::GaussianBlur(luminance, smooth, {}, 1.1);
  cv::Sobel(smooth, dx, CV_32F, 1, 0, 3, 1000);
  cv::Sobel(smooth, dy, CV_32F, 0, 1, 3, 1000);
  dx.convertTo(dx, CV_16S);
  dy.convertTo(dy, CV_16S);
  cv::Canny(dx, dy, edges, 90, 210, true);
  return edges;
}

/// Removes connected lines shorter than `pixels`.
void RemoveShort(cv::Mat& mask, int pixels) {
  cv::Mat labels, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, statistics, centroids, 8);
  std::vector<bool> keep(static_cast<std::size_t>(count));
  for (int i = 1; i < count; ++i)
    keep[static_cast<std::size_t>(i)] = statistics.at<int>(i, cv::CC_STAT_AREA) >= pixels;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if (!keep[static_cast<std::size_t>(labels.at<int>(y, x))]) mask.at<std::uint8_t>(y, x) = 0;
    }
  }
}

/// Normal of the line through a pixel: principal direction of the line's pixels connected with it
/// in a small window.
cv::Point2f LineNormal(const cv::Mat& mask, int x, int y) {
  constexpr int kReach = 5, kSide = 2 * kReach + 1;
  std::array<bool, kSide * kSide> seen{};
  std::array<cv::Point, kSide * kSide> queue;
  int filled = 0;
  queue[filled++] = {0, 0};
  seen[kReach * kSide + kReach] = true;
  float xx = 0, xy = 0, yy = 0;
  for (int next = 0; next < filled; ++next) {
    const cv::Point at = queue[next];
    const auto px = static_cast<float>(at.x), py = static_cast<float>(at.y);
    const float weight = std::exp(-(px * px + py * py) / 18);
    xx += weight * px * px;
    xy += weight * px * py;
    yy += weight * py * py;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const cv::Point to(at.x + dx, at.y + dy);
        if (std::abs(to.x) > kReach || std::abs(to.y) > kReach) continue;
        const int ix = x + to.x, iy = y + to.y;
        if (ix < 0 || iy < 0 || ix >= mask.cols || iy >= mask.rows ||
            !mask.at<std::uint8_t>(iy, ix))
          continue;
        bool& visited = seen[static_cast<std::size_t>((to.y + kReach) * kSide + to.x + kReach)];
        if (!visited) {
          visited = true;
          queue[filled++] = to;
        }
      }
    }
  }
  const float tangent = 0.5f * std::atan2(2 * xy, xx - yy);
  return {-std::sin(tangent), std::cos(tangent)};
}

/// Largest difference of a colour channel across the line.
float ContrastAcross(const cv::Mat& picture, int x, int y, const cv::Point2f& normal) {
  const auto at = [&](float offset) {
    const int px =
        std::clamp(static_cast<int>(std::lround(static_cast<float>(x) + offset * normal.x)), 0,
                   picture.cols - 1);
    const int py =
        std::clamp(static_cast<int>(std::lround(static_cast<float>(y) + offset * normal.y)), 0,
                   picture.rows - 1);
    return picture.at<cv::Vec3f>(py, px);
  };
  const cv::Vec3f difference = at(2.5f) - at(-2.5f);
  return std::max({std::abs(difference[0]), std::abs(difference[1]), std::abs(difference[2])});
}

std::uint8_t AngleByte(const cv::Point2f& normal) {
  float angle = std::atan2(normal.y, normal.x);
  if (angle < 0) angle += kPiF;
  return static_cast<std::uint8_t>(static_cast<int>(std::lround(angle * 256 / kPiF)) & 255);
}

void Draw(EdgeMap& map, int x, int y, float probability, const cv::Point2f& normal) {
  if (x < 0 || y < 0 || x >= map.probability.cols || y >= map.probability.rows) return;
  const auto value = cv::saturate_cast<std::uint8_t>(255 * probability);
  std::uint8_t& there = map.probability.at<std::uint8_t>(y, x);
  if (value <= there) return;
  there = value;
  map.angle.at<std::uint8_t>(y, x) = AngleByte(normal);
}

/// Smooth noise over the image that also changes with time, mean 0.
float Wander(int x, int y, int frame, float size_px, std::uint32_t seed) {
  return ValueNoise({static_cast<float>(x) / size_px, static_cast<float>(y) / size_px,
                     0.4f * static_cast<float>(frame)},
                    seed) -
         0.5f;
}

/// The value below which a share of the values lies.
float Quantile(std::vector<float> values, double share) {
  if (values.empty()) return 0;
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

std::vector<EdgePoint> MeasurePoints(const cv::Mat& lines, const cv::Mat& geometric,
                                     const cv::Mat& picture) {
  std::vector<cv::Point> places;
  cv::findNonZero(lines, places);
  std::vector<EdgePoint> points(places.size());
  tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
    const cv::Point at = places[i];
    const cv::Point2f normal = LineNormal(lines, at.x, at.y);
    points[i] = {at.x, at.y, normal, ContrastAcross(picture, at.x, at.y, normal),
                 geometric.at<std::uint8_t>(at) > 0};
  });
  return points;
}

/// Short false lines, as an edge detector finds in texture.
void AddSpurious(EdgeMap& map, int pixels, std::uint64_t seed, int frame) {
  Random random({.seed = seed, .frame = static_cast<std::uint32_t>(frame), .object = 0x737075});
  while (pixels > 0) {
    auto x = static_cast<float>(random.Uniform(0, map.probability.cols));
    auto y = static_cast<float>(random.Uniform(0, map.probability.rows));
    auto heading = static_cast<float>(random.Uniform(0, 2 * kPiF));
    const auto bend = static_cast<float>(random.Uniform(-0.08, 0.08));
    const int length = 6 + static_cast<int>(random.Index(15));
    const auto probability = static_cast<float>(random.Uniform(0.12, 0.45));
    for (int i = 0; i < length; ++i) {
      Draw(map, static_cast<int>(std::lround(x)), static_cast<int>(std::lround(y)), probability,
           {-std::sin(heading), std::cos(heading)});
      x += std::cos(heading);
      y += std::sin(heading);
      heading += bend;
    }
    pixels -= length;
  }
}

}  // namespace

cv::Mat GeometricEdges(const PinholeCamera& camera, const SurfaceMaps& maps) {
  cv::Mat edges(maps.depth.size(), CV_8U, cv::Scalar(0));
  const float crease = std::cos(28 * kPiF / 180);
  for (int y = 0; y < edges.rows; ++y) {
    for (int x = 0; x < edges.cols; ++x) {
      const float z = maps.depth.at<float>(y, x);
      const cv::Vec3f bearing = BearingOf(camera, x, y);
      for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{0, 1}}) {
        const int qx = x + dx, qy = y + dy;
        if (qx >= edges.cols || qy >= edges.rows) continue;
        const float zq = maps.depth.at<float>(qy, qx);
        if (z <= 0 && zq <= 0) continue;
        const cv::Vec3f& n = maps.normal.at<cv::Vec3f>(y, x);
        const cv::Vec3f& nq = maps.normal.at<cv::Vec3f>(qy, qx);
        const cv::Vec3f bearing_q = BearingOf(camera, qx, qy);
        const float allowed = 0.01f + 0.008f * std::min(z, zq);
        const bool step = z <= 0 || zq <= 0 ||
                          (std::abs(PlaneDepth(z, n, bearing, bearing_q) - zq) > allowed &&
                           std::abs(PlaneDepth(zq, nq, bearing_q, bearing) - z) > allowed &&
                           std::abs(z - zq) > allowed);
        if (step) {
          const bool near_is_q = z <= 0 || (zq > 0 && zq < z);
          edges.at<std::uint8_t>(near_is_q ? qy : y, near_is_q ? qx : x) = 255;
        } else if (n.dot(nq) < crease) {
          edges.at<std::uint8_t>(y, x) = 255;
        }
      }
    }
  }
  return edges;
}

EdgeMap DetectSyntheticEdges(const PinholeCamera& camera, const SurfaceMaps& maps,
                             const cv::Mat& picture, const EdgeFlaws& flaws, std::uint64_t seed,
                             int frame) {
  cv::Mat geometric = GeometricEdges(camera, maps);
  cv::Mat luminance, nearby;
  cv::cvtColor(picture, luminance, cv::COLOR_RGB2GRAY);
  cv::Mat lines = PictureEdges(luminance);
  cv::dilate(geometric, nearby, cv::Mat::ones(5, 5, CV_8U));
  lines.setTo(0, nearby);
  RemoveShort(lines, 9);
  lines |= geometric;
  Thin(lines);
  RemoveShort(lines, 5);

  const std::vector<EdgePoint> points = MeasurePoints(lines, geometric, picture);
  const auto noise_seed = static_cast<std::uint32_t>(seed * 2654435761U);
  std::vector<float> gap_noise, shift_noise;
  for (const EdgePoint& point : points) {
    // Weak contrast opens gaps first.
    gap_noise.push_back(Wander(point.x, point.y, frame, 11, noise_seed) +
                        0.25f * std::min(0.12f, point.contrast) / 0.12f);
    shift_noise.push_back(Wander(point.x, point.y, frame, 7, noise_seed + 1));
  }
  const float gap = Quantile(gap_noise, flaws.dropped);
  double spread = 1e-9;
  for (const float value : shift_noise) spread += value * value;
  const auto shift_scale = static_cast<float>(
      flaws.jitter_px / std::sqrt(spread / std::max<std::size_t>(1, points.size())));

  EdgeMap map{cv::Mat(maps.depth.size(), CV_8U, cv::Scalar(0)),
              cv::Mat(maps.depth.size(), CV_8U, cv::Scalar(0))};
  int drawn = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (flaws.dropped > 0 && gap_noise[i] <= gap) continue;
    const EdgePoint& point = points[i];
    const float shift = shift_noise[i] * shift_scale;
    const float floor = point.geometric ? 0.3f : 0.1f;
    const float probability = floor + (1 - floor) * (1 - std::exp(-point.contrast / 0.07f));
    Draw(map, static_cast<int>(std::lround(static_cast<float>(point.x) + shift * point.normal.x)),
         static_cast<int>(std::lround(static_cast<float>(point.y) + shift * point.normal.y)),
         probability, point.normal);
    ++drawn;
  }
  AddSpurious(map, static_cast<int>(flaws.spurious * drawn), seed, frame);
  return map;
}

}  // namespace plumbline
