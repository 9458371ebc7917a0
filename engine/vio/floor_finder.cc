// SPDX-License-Identifier: Apache-2.0
#include "engine/vio/floor_finder.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

namespace plumbline {
namespace {

constexpr std::size_t kMemory = 4000;   // points
constexpr double kStep_m = 0.01;        // between heights that are tried
constexpr double kWidth = 1.5;          // of the band, in spreads to both sides
constexpr double kPeak = 2;             // denser than the band above it by this factor
constexpr double kBelow = 0.3;          // of the points in the band, at most, lie below it
constexpr double kLeastExtent_m = 0.4;  // of the points on the floor, horizontally
constexpr int kImagesTogether = 15;     // points of so many images err together
constexpr std::size_t kLeastLooks = 4;  // from so many groups of images
constexpr double kLeastStd_m = 0.01;    // no floor is more even, nor found better

}  // namespace

void FloorFinder::Add(const Eigen::Vector3d& point_in_world, int image) {
  points_.push_back({point_in_world.z(), image, point_in_world.x(), point_in_world.y()});
  if (points_.size() > kMemory) points_.pop_front();
}

std::optional<FloorReport> FloorFinder::Find(double camera_height_m) const {
  std::vector<Point> points(points_.begin(), points_.end());
  std::stable_sort(points.begin(), points.end(),
                   [](const Point& a, const Point& b) { return a.height_m < b.height_m; });
  const auto below = [&](double height) {
    return std::lower_bound(points.begin(), points.end(), height,
                            [](const Point& p, double h) { return p.height_m < h; });
  };
  const double half = kWidth * options_.floor_spread_m;
  const double highest = camera_height_m - options_.floor_camera_height_m;
  if (points.empty()) return std::nullopt;
  for (double height = points.front().height_m; height <= highest; height += kStep_m) {
    const auto first = below(height - half), last = below(height + half);
    const auto inside = last - first;
    if (inside < options_.floor_points) continue;
    if (static_cast<double>(first - points.begin()) > kBelow * static_cast<double>(inside))
      return std::nullopt;  // no level stands out from what is below it
    // Climb to the middle of the peak.
    double center = height, sum = 0, squares = 0;
    std::vector<Point> floor;
    for (int i = 0; i < 20; ++i) {
      floor.assign(below(center - half), below(center + half));
      sum = squares = 0;
      for (const Point& point : floor) sum += point.height_m;
      const double mean = sum / static_cast<double>(floor.size());
      if (std::abs(mean - center) < 1e-4) break;
      center = mean;
    }
    const auto count = static_cast<double>(floor.size());
    const auto above = static_cast<double>(below(center + 3 * half) - below(center + half));
    if (count < kPeak * above / 2 || center > highest) continue;
    double min_x = 1e9, max_x = -1e9, min_y = 1e9, max_y = -1e9;
    std::set<int> looks;
    for (const Point& point : floor) {
      squares += (point.height_m - center) * (point.height_m - center);
      min_x = std::min(min_x, point.x);
      max_x = std::max(max_x, point.x);
      min_y = std::min(min_y, point.y);
      max_y = std::max(max_y, point.y);
      looks.insert(point.image / kImagesTogether);
    }
    if (std::min(max_x - min_x, max_y - min_y) < kLeastExtent_m || looks.size() < kLeastLooks)
      continue;
    FloorReport found;
    found.height_m = center;
    // The band cuts the tails off, so that the spread is at least what the options say.
    const double spread = std::max(std::sqrt(squares / count), options_.floor_spread_m);
    found.std_m = std::hypot(spread / std::sqrt(static_cast<double>(looks.size())), kLeastStd_m);
    found.points = static_cast<int>(floor.size());
    return found;
  }
  return std::nullopt;
}

}  // namespace plumbline
