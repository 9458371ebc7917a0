// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/support_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace plumbline {
namespace {

constexpr double kLevel_m = 0.02;       ///< Faces within this are of one level.
constexpr double kLevelCosine = 0.985;  ///< Of their slope: 10 degrees.
constexpr double kLeastCover = 0.5;     ///< Of the footprint.
constexpr double kFoot_m = 0.02;        ///< Above the lowest point.
constexpr double kOverhang_m = 0.02;    ///< Deviation, of things that stand on the edge of others.
constexpr double kHovering_m = 0.1;  ///< Nothing is so near above a surface but what stands there.
constexpr double kHeights_m = 2;  ///< That things are found at, where they stand on nothing mapped.

}  // namespace

std::optional<double> SupportHeight(const CadModel& model) {
  std::vector<std::pair<double, double>> level_and_area;
  for (const auto& triangle : model.mesh.triangles) {
    const auto corner = [&](int k) -> Eigen::Vector3d {
      return model.mesh.vertices[triangle[k]].cast<double>();
    };
    const Eigen::Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    if (normal.norm() <= 0 || normal.z() < kLevelCosine * normal.norm()) continue;
    level_and_area.emplace_back((corner(0).z() + corner(1).z() + corner(2).z()) / 3,
                                0.5 * normal.z());
  }
  std::sort(level_and_area.rbegin(), level_and_area.rend());
  const double wanted = kLeastCover * model.bounds.sizes().x() * model.bounds.sizes().y();
  for (std::size_t i = 0; i < level_and_area.size(); ++i) {
    double area = 0, moment = 0;
    for (std::size_t j = i; j < level_and_area.size(); ++j) {
      const auto& [level, part] = level_and_area[j];
      if (level < level_and_area[i].first - kLevel_m) break;
      area += part;
      moment += part * level;
    }
    if (area >= wanted) return moment / area;
  }
  return std::nullopt;
}

Eigen::AlignedBox2d FootOf(const CadModel& model) {
  Eigen::AlignedBox2d foot;
  for (const Eigen::Vector3f& vertex : model.mesh.vertices) {
    if (vertex.z() < model.bounds.min().z() + kFoot_m) foot.extend(vertex.head<2>().cast<double>());
  }
  return foot;
}

double SupportSurface::Overhang(const Eigen::Vector2d& point) const {
  double beyond_m = 0;
  for (const Eigen::Vector2d& side : {side_a, side_b}) {
    const double along_m = (point - corner).dot(side) / side.norm();
    beyond_m = std::max({beyond_m, -along_m, along_m - side.norm()});
  }
  return beyond_m;
}

Eigen::Vector3d SupportSurface::Draw(Random& random) const {
  const double a = random.Uniform(), b = random.Uniform();
  Eigen::Vector3d point;
  point << corner + a * side_a + b * side_b, height_m + height_std_m * random.Gaussian();
  return point;
}

SupportSurface MakeSupportSurface(const CadModel& model, double support_height_m,
                                  const Eigen::Isometry3d& world_from_object, double scale,
                                  const UprightFrame& upright, double height_std_m) {
  const Eigen::AlignedBox3d box = Scaled(model.bounds, scale);
  const Eigen::Isometry3d upright_from_object =
      Eigen::Isometry3d(upright.upright_rotation().transpose()) * world_from_object;
  SupportSurface surface;
  const Eigen::Vector3d corner =
      upright_from_object * Eigen::Vector3d(box.min().x(), box.min().y(), scale * support_height_m);
  surface.corner = corner.head<2>();
  surface.side_a = (upright_from_object.linear().col(0) * box.sizes().x()).head<2>();
  surface.side_b = (upright_from_object.linear().col(1) * box.sizes().y()).head<2>();
  surface.height_m = corner.z();
  surface.height_std_m = height_std_m;
  return surface;
}

double LogSupportPrior(const std::vector<SupportSurface>& surfaces, const StandingThing& thing) {
  double on = 0, elsewhere = 1;
  for (const SupportSurface& surface : surfaces) {
    double least_m = surface.Overhang(thing.base.head<2>()), most_m = 0;
    for (const Eigen::Vector2d& corner : thing.foot) {
      least_m = std::min(least_m, surface.Overhang(corner));
      most_m = std::max(most_m, surface.Overhang(corner));
    }
    if (least_m > 0) continue;  // beside it
    const double above_m = thing.base.z() - surface.height_m;
    if (above_m < kHovering_m && above_m + thing.height_m > 0) elsewhere = kNoSurface;
    const double off = above_m / surface.height_std_m, over = most_m / kOverhang_m;
    on = std::max(on, std::exp(-0.5 * (off * off + over * over)) /
                          (std::sqrt(2 * std::numbers::pi) * surface.height_std_m));
  }
  return std::log(elsewhere + kHeights_m * on);
}

}  // namespace plumbline
