// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/surface_error.h"

#include <algorithm>
#include <cmath>

namespace plumbline {

ErrorStatistics Statistics(std::vector<double> distances_m) {
  ErrorStatistics statistics;
  statistics.samples = static_cast<int>(distances_m.size());
  if (distances_m.empty()) return statistics;
  const double count = static_cast<double>(distances_m.size());
  double sum = 0;
  for (const double distance : distances_m) {
    sum += distance;
    statistics.max_m = std::max(statistics.max_m, distance);
  }
  statistics.mean_m = sum / count;
  double squares = 0;
  for (const double distance : distances_m) {
    squares += (distance - statistics.mean_m) * (distance - statistics.mean_m);
  }
  statistics.std_m = std::sqrt(squares / count);
  const auto middle = distances_m.begin() + static_cast<std::ptrdiff_t>(distances_m.size() / 2);
  std::nth_element(distances_m.begin(), middle, distances_m.end());
  statistics.median_m = *middle;
  if (distances_m.size() % 2 == 0) {
    statistics.median_m = 0.5 * (*middle + *std::max_element(distances_m.begin(), middle));
  }
  return statistics;
}

SurfaceDistances MeasureDistances(const std::vector<Eigen::Vector3d>& points,
                                  const ClosestTriangleSearch& surface) {
  std::vector<ClosestPoint> closest(points.size());
  surface.Find(points, closest);
  SurfaceDistances distances;
  distances.to_triangle_m.reserve(points.size());
  distances.to_plane_m.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double distance = closest[i].distance_m;
    const Eigen::Vector3d normal = surface.Normal(closest[i].triangle);
    const double to_plane = std::abs(normal.dot(points[i] - closest[i].point));
    distances.to_triangle_m.push_back(distance);
    distances.to_plane_m.push_back(normal.isZero() ? distance : std::min(to_plane, distance));
  }
  return distances;
}

}  // namespace plumbline
