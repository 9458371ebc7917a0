// SPDX-License-Identifier: Apache-2.0
#include "engine/session/place_beside.h"

#include <array>
#include <optional>
#include <vector>

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr double kGap = 0.05;         ///< Between the two, of its width.
constexpr double kTouching_m = 0.01;  ///< Boxes that are this deep in each other still are apart.
constexpr int kRings = 4;
constexpr double kUnknownWidth_m = 0.5;

/// A model's box where it stands.
struct PosedBox {
  Eigen::Isometry3d scan_from_object;
  Eigen::AlignedBox3d box;

  Vector3d center() const { return scan_from_object * box.center(); }
  /// Half its length along a unit vector.
  double Reach(const Vector3d& direction) const {
    return (scan_from_object.linear().transpose() * direction).cwiseAbs().dot(box.sizes()) / 2;
  }
};

std::optional<PosedBox> BoxOf(const AnnotatedInstance& instance, const ModelDatabase* models) {
  const auto model = models != nullptr ? models->Find(instance.model) : std::nullopt;
  if (!model || models->model(*model).bounds.isEmpty()) return std::nullopt;
  const Eigen::AlignedBox3d bounds = models->model(*model).bounds.cast<double>();
  return PosedBox{instance.scan_from_object,
                  {instance.scale * bounds.min(), instance.scale * bounds.max()}};
}

/// Tries the faces of both as planes between them: may say so of boxes that just miss each other.
bool Overlap(const PosedBox& a, const PosedBox& b) {
  const Vector3d between = b.center() - a.center();
  for (const PosedBox* box : {&a, &b}) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d normal = box->scan_from_object.linear().col(axis);
      if (std::abs(between.dot(normal)) > a.Reach(normal) + b.Reach(normal) - kTouching_m)
        return false;
    }
  }
  return true;
}

/// Left, right, behind, ahead of it, level; those that it has.
std::vector<Vector3d> SidesOf(const AnnotatedInstance& original, const Vector3d& up) {
  const Eigen::Matrix3d axes = original.scan_from_object.linear();
  std::vector<Vector3d> sides;
  for (const Vector3d& side :
       std::array<Vector3d, 4>{axes.col(1), -axes.col(1), -axes.col(0), axes.col(0)}) {
    const Vector3d level = side - side.dot(up) * up;
    if (level.norm() > 0.1) sides.push_back(level.normalized());
  }
  return sides;
}

}  // namespace

Eigen::Isometry3d PlaceBeside(const AnnotatedInstance& original, const AnnotationDocument& document,
                              const ModelDatabase* models) {
  const std::vector<Vector3d> sides = SidesOf(original, -document.gravity_in_scan);
  const auto box = BoxOf(original, models);
  const auto beside = [&](const Vector3d& side, int ring) {
    const double width_m = box ? 2 * box->Reach(side) : kUnknownWidth_m;
    Eigen::Isometry3d pose = original.scan_from_object;
    pose.translation() += ring * (1 + kGap) * width_m * side;
    return pose;
  };
  if (!box) return beside(sides.front(), 1);
  std::vector<PosedBox> others;
  for (const AnnotatedInstance& instance : document.instances) {
    const auto other = BoxOf(instance, models);
    // What it stands on, or is pushed under, is no obstacle to its copy either.
    if (instance.id != original.id && other && !Overlap(*other, *box)) others.push_back(*other);
  }
  for (int ring = 1; ring <= kRings; ++ring) {
    for (const Vector3d& side : sides) {
      const PosedBox copy{beside(side, ring), box->box};
      bool free = true;
      for (const PosedBox& other : others) free = free && !Overlap(copy, other);
      if (free) return copy.scan_from_object;
    }
  }
  return beside(sides.front(), 1);
}

}  // namespace plumbline
