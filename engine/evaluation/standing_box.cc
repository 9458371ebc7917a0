// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/standing_box.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace plumbline {
namespace {

using Polygon = std::vector<Eigen::Vector2d>;

double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

template <typename Corners>
double AreaOf(const Corners& corners) {
  double twice = 0;
  for (std::size_t i = 0; i < corners.size(); ++i)
    twice += Cross(corners[i], corners[(i + 1) % corners.size()]);
  return 0.5 * twice;
}

/// What of a convex polygon lies left of the line from a to b: one step of the clipping of I.
/// Sutherland and G. Hodgman, "Reentrant polygon clipping", 1974.
Polygon LeftOf(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Polygon& polygon) {
  Polygon left;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& from = polygon[i];
    const Eigen::Vector2d& to = polygon[(i + 1) % polygon.size()];
    const double side_from = Cross(b - a, from - a), side_to = Cross(b - a, to - a);
    if (side_from >= 0) left.push_back(from);
    if (side_from * side_to < 0)
      left.push_back(from + side_from / (side_from - side_to) * (to - from));
  }
  return left;
}

double SharedArea(const StandingBox& a, const StandingBox& b) {
  Polygon shared(a.base.begin(), a.base.end());
  for (std::size_t i = 0; i < b.base.size() && !shared.empty(); ++i)
    shared = LeftOf(b.base[i], b.base[(i + 1) % b.base.size()], shared);
  return std::max(0.0, AreaOf(shared));
}

}  // namespace

double StandingBox::volume() const { return AreaOf(base) * (top_m - bottom_m); }

StandingBox BoxOf(const CadModel& model, const Eigen::Isometry3d& world_from_object, double scale,
                  const UprightFrame& upright) {
  const double azimuth = upright.Azimuth(world_from_object.linear());
  const Eigen::Isometry3d level_from_object =
      upright.WorldFromObjectRotation(azimuth).transpose() * world_from_object;
  Eigen::AlignedBox3d bounds;
  for (const Eigen::Vector3f& vertex : model.mesh.vertices)
    bounds.extend(level_from_object * (scale * vertex.cast<double>()));
  StandingBox box;
  box.bottom_m = bounds.min().z();
  box.top_m = bounds.max().z();
  const Eigen::Rotation2Dd turn(azimuth);
  box.base = {turn * Eigen::Vector2d(bounds.min().x(), bounds.min().y()),
              turn * Eigen::Vector2d(bounds.max().x(), bounds.min().y()),
              turn * Eigen::Vector2d(bounds.max().x(), bounds.max().y()),
              turn * Eigen::Vector2d(bounds.min().x(), bounds.max().y())};
  return box;
}

StandingBox BoxOf(const Eigen::Vector3d& size_m, const Eigen::Isometry3d& world_from_object,
                  const UprightFrame& upright) {
  const Eigen::Vector3d base =
      upright.upright_rotation().transpose() * world_from_object.translation();
  const Eigen::Rotation2Dd turn(upright.Azimuth(world_from_object.linear()));
  const double x = 0.5 * size_m.x(), y = 0.5 * size_m.y();
  const auto corner = [&](double along, double across) {
    return Eigen::Vector2d(base.head<2>() + turn * Eigen::Vector2d(along, across));
  };
  StandingBox box;
  box.base = {corner(-x, -y), corner(x, -y), corner(x, y), corner(-x, y)};
  box.bottom_m = base.z();
  box.top_m = base.z() + size_m.z();
  return box;
}

std::array<Eigen::Vector3d, 8> CornersOf(const StandingBox& box, const UprightFrame& upright) {
  std::array<Eigen::Vector3d, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    const Eigen::Vector2d& base = box.base[i % 4];
    corners[i] = upright.upright_rotation() *
                 Eigen::Vector3d(base.x(), base.y(), i < 4 ? box.bottom_m : box.top_m);
  }
  return corners;
}

double BaseIou(const StandingBox& a, const StandingBox& b) {
  const double both = SharedArea(a, b);
  const double together = AreaOf(a.base) + AreaOf(b.base) - both;
  return together > 0 ? both / together : 0.0;
}

double Iou(const StandingBox& a, const StandingBox& b) {
  const double height_m = std::min(a.top_m, b.top_m) - std::max(a.bottom_m, b.bottom_m);
  if (!(height_m > 0)) return 0;
  const double both = SharedArea(a, b) * height_m;
  const double together = a.volume() + b.volume() - both;
  return together > 0 ? both / together : 0.0;
}

}  // namespace plumbline
