// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/surface_sampling.h"

namespace plumbline {

/// Of distances [m]. Without samples all numbers are 0 and mean nothing.
struct ErrorStatistics {
  double mean_m = 0, median_m = 0, std_m = 0, max_m = 0;
  int samples = 0;
};

/// The standard deviation is that of the sample itself (divided by n).
ErrorStatistics Statistics(std::vector<double> distances_m);

/// Distances of sample points to a surface; entry i belongs to sample i.
struct SurfaceDistances {
  std::vector<double> to_triangle_m;  ///< To the closest point of the closest triangle.
  std::vector<double> to_plane_m;     ///< To the plane of that triangle: at most the former.
};

SurfaceDistances MeasureDistances(const std::vector<Eigen::Vector3d>& points,
                                  const ClosestTriangleSearch& surface);

}  // namespace plumbline
