// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/floor_level.h"

namespace plumbline {

bool Holds(const FloorLevel& level, const Eigen::Vector3d& point_in_world,
           const UprightFrame& upright) {
  const auto seen_from_above = [&](const Eigen::Vector3d& point) -> Eigen::Vector2d {
    return (upright.upright_rotation().transpose() * point).head<2>();
  };
  const Eigen::Vector2d point = seen_from_above(point_in_world);
  // Odd where a ray along +x crosses the sides an odd number of times.
  bool inside = false;
  const auto& corners = level.outline_in_world;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = seen_from_above(corners[i]),
                          b = seen_from_above(corners[(i + 1) % corners.size()]);
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (x > point.x()) inside = !inside;
  }
  return inside;
}

}  // namespace plumbline
