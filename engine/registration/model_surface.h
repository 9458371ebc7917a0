// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/mesh.h"
#include "engine/geometry/point_tree.h"
#include "engine/registration/scan_target.h"

namespace plumbline {

/// A CAD model made ready for aligning, in its own frame. Immutable; share it.
class ModelSurface {
 public:
  /// Errors: kDegenerate for a mesh without faces of positive area (a point cloud).
  static Result<std::shared_ptr<const ModelSurface>> Prepare(const TriangleMesh& model);

  const ClosestTriangleSearch& triangles() const { return *triangles_; }
  /// Points spread evenly over what can be seen from outside (always the same ones). Normals face
  /// out, by what rays can reach, not by the order of corners.
  const OrientedPoints& samples() const { return samples_; }
  /// Of each sample: whether both sides of its face can be seen, so that its normal has no sign.
  const std::vector<char>& two_sided() const { return two_sided_; }
  struct Face {
    Eigen::Vector3d normal;  ///< Unit, out.
    bool two_sided;
  };
  Face face(int triangle) const { return faces_[static_cast<std::size_t>(triangle)]; }
  const PointTree& sample_tree() const { return sample_tree_; }
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

  /// Order of the rotational symmetry of the shape about its +z through its middle: 1 none, n for
  /// turns by 360/n degrees, 0 for any turn. Turns that leave all but a few points within
  /// `tolerance_m` of the surface count.
  int SymmetryOrder(double tolerance_m) const;
  /// Where that axis is: the middle of the surface [m].
  const Eigen::Vector3d& middle() const { return middle_; }

 private:
  ModelSurface(std::unique_ptr<const ClosestTriangleSearch> triangles, std::vector<Face> faces,
               OrientedPoints samples, std::vector<char> two_sided, const Eigen::Vector3d& middle);
  bool LooksTheSame(double turn_rad, double tolerance_m) const;

  std::unique_ptr<const ClosestTriangleSearch> triangles_;
  std::vector<Face> faces_;
  OrientedPoints samples_;
  std::vector<char> two_sided_;
  PointTree sample_tree_;
  Eigen::AlignedBox3d bounds_;
  Eigen::Vector3d middle_{0, 0, 0};
};

}  // namespace plumbline
