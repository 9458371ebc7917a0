// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/contact.h"

#include <algorithm>
#include <array>
#include <limits>

#include "engine/geometry/surface_sampling.h"

namespace plumbline {
namespace {

constexpr int kSurfacePoints = 600;

/// The shortest horizontal way from a point out of a model, both in its `object` axes; nothing
/// outside.
std::optional<Eigen::Vector3f> WayOut(const OutlineModel& model, const Eigen::Vector3f& point) {
  const auto distance = [&](const Eigen::Vector3f& direction) {
    const float hit = model.rays().Cast(point, direction).distance;
    return hit > 0 ? std::optional(hit) : std::nullopt;
  };
  const std::optional<float> above = distance(Eigen::Vector3f::UnitZ());
  if (!above) return std::nullopt;
  float nearest = std::numeric_limits<float>::infinity();
  Eigen::Vector3f way;
  const std::array<Eigen::Vector3f, 4> sides = {Eigen::Vector3f::UnitX(), -Eigen::Vector3f::UnitX(),
                                                Eigen::Vector3f::UnitY(),
                                                -Eigen::Vector3f::UnitY()};
  for (const Eigen::Vector3f& side : sides) {
    const std::optional<float> hit = distance(side);
    if (!hit) return std::nullopt;
    if (*hit >= nearest) continue;
    nearest = *hit;
    way = *hit * side;
  }
  const float below = distance(-Eigen::Vector3f::UnitZ()).value_or(nearest);
  if (std::min(*above, below) < nearest) return std::nullopt;
  return way;
}

/// The longest way by which a point of `a` has to leave `b`, in world.
Eigen::Vector3d LongestWayOut(const SolidModel& a, const Eigen::Isometry3d& world_from_a,
                              const SolidModel& b, const Eigen::Isometry3d& world_from_b) {
  const Eigen::Isometry3f b_from_a = (world_from_b.inverse() * world_from_a).cast<float>();
  Eigen::Vector3f longest = Eigen::Vector3f::Zero();
  for (const Eigen::Vector3f& in_a : a.surface) {
    const Eigen::Vector3f point = b_from_a * in_a;
    if ((point - b.outline->center()).norm() > b.outline->radius()) continue;
    const std::optional<Eigen::Vector3f> way = WayOut(*b.outline, point);
    if (way && way->norm() > longest.norm()) longest = *way;
  }
  return world_from_b.linear() * longest.cast<double>();
}

}  // namespace

Result<SolidModel> SolidModel::Prepare(const CadModel& model) {
  SolidModel solid;
  auto outline = OutlineModel::Prepare(model.mesh);
  if (!outline.ok()) return outline.error();
  solid.outline = *outline;
  const Result<SurfaceSamples> samples = SampleSurface(model.mesh, kSurfacePoints, 0);
  if (!samples.ok()) return samples.error();
  for (const Eigen::Vector3d& point : samples->points) solid.surface.push_back(point.cast<float>());
  return solid;
}

std::optional<Contact> FindContact(const SolidModel& a, const Eigen::Isometry3d& world_from_a,
                                   const SolidModel& b, const Eigen::Isometry3d& world_from_b) {
  const Eigen::Vector3d centre_a = world_from_a * a.outline->center().cast<double>();
  const Eigen::Vector3d centre_b = world_from_b * b.outline->center().cast<double>();
  if ((centre_a - centre_b).norm() >
      static_cast<double>(a.outline->radius() + b.outline->radius())) {
    return std::nullopt;
  }
  const Eigen::Vector3d a_leaves = LongestWayOut(a, world_from_a, b, world_from_b);
  const Eigen::Vector3d b_leaves = LongestWayOut(b, world_from_b, a, world_from_a);
  const Eigen::Vector3d way = a_leaves.norm() >= b_leaves.norm() ? a_leaves : -b_leaves;
  if (way.norm() < 1e-9) return std::nullopt;
  return Contact{way.normalized(), way.norm()};
}

}  // namespace plumbline
