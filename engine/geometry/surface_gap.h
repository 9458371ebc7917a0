// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/mesh.h"
#include "engine/geometry/point_tree.h"

namespace plumbline {

struct PlacedSurface;

/// A mesh made ready for measuring how far it is from others: made once, then moved about.
/// Immutable; safe to use from several threads.
class MeasuredSurface {
 public:
  /// Errors: kDegenerate for a mesh without area.
  static Result<std::unique_ptr<MeasuredSurface>> Make(const TriangleMesh& mesh);

  /// A few hundred points spread evenly by area [m].
  const std::vector<Eigen::Vector3d>& points() const { return points_; }
  const Eigen::AlignedBox3d& box() const { return box_; }

 private:
  friend double SurfaceGap(const PlacedSurface& a, const PlacedSurface& b);
  MeasuredSurface(PointTree tree) : tree_(std::move(tree)) {}

  std::vector<Eigen::Vector3d> points_;
  PointTree tree_;  ///< Of many more points.
  std::unique_ptr<ClosestTriangleSearch> triangles_;
  Eigen::AlignedBox3d box_;
};

/// A surface somewhere, times as large as its mesh about the mesh's origin.
struct PlacedSurface {
  const MeasuredSurface& surface;
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
  double scale = 1;

  Eigen::Affine3d world_from_mesh() const { return world_from_object * Eigen::Scaling(scale); }
};

/// The smallest distance between two surfaces [m]; near 0 where they touch or cross. Found among
/// points spread over both, then by going from one surface to the closest point of the other and
/// back until nothing gets closer: never below the true distance, and equal to it unless two places
/// are within a few millimetres of being the closest. About 0.5 ms.
double SurfaceGap(const PlacedSurface& a, const PlacedSurface& b);

/// A quick lower bound of it: the distance between spheres around the two.
double GapAtLeast(const PlacedSurface& a, const PlacedSurface& b);

}  // namespace plumbline
