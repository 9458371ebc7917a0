// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/scene_geometry.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace plumbline {

using Eigen::Vector3d;

std::optional<ImVec2> ScreenOf(const AnnotateSurface& scene, ImVec2 low, const Vector3d& in_level) {
  const auto pixel = scene.Project(in_level);
  if (!pixel) return std::nullopt;
  return ImVec2(low.x + static_cast<float>(pixel->x()), low.y + static_cast<float>(pixel->y()));
}

double DistanceToLine(ImVec2 p, ImVec2 a, ImVec2 b) {
  const Eigen::Vector2d u(b.x - a.x, b.y - a.y), v(p.x - a.x, p.y - a.y);
  const double t = std::clamp(u.dot(v) / std::max(1e-9, u.squaredNorm()), 0.0, 1.0);
  return (v - t * u).norm();
}

double DistanceTo(const std::vector<ImVec2>& line, ImVec2 p) {
  double least = 1e9;
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    least = std::min(least, DistanceToLine(p, line[i], line[i + 1]));
  }
  return least;
}

std::optional<Vector3d> OnPlane(const SightLine& sight, const Vector3d& point,
                                const Vector3d& normal) {
  constexpr double kFlattest = 0.12;  // sine of the angle
  const double slope = sight.direction.dot(normal);
  if (std::abs(slope) < kFlattest) return std::nullopt;
  const double along = (point - sight.eye).dot(normal) / slope;
  if (along <= 0) return std::nullopt;
  return Vector3d(sight.eye + along * sight.direction);
}

void LogRect(const FrameContext& context, std::string name, ImVec2 middle, float half) {
  if (context.widgets == nullptr) return;
  context.widgets->Add(std::move(name), {middle.x - half, middle.y - half},
                       {middle.x + half, middle.y + half});
}

}  // namespace plumbline
