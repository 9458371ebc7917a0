// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"
#include "engine/geometry/point_tree.h"

namespace plumbline {

/// Points with unit normals.
struct OrientedPoints {
  std::vector<Eigen::Vector3f> points;  ///< [m]
  std::vector<Eigen::Vector3f> normals;
};

/// A scan made ready for aligning: normals and a k-d tree, made once. Immutable; share it.
class ScanTarget {
 public:
  /// Takes normals from the scan, else from its triangles, else from the 16 nearest points; the
  /// latter face the nearest of `camera_centers` (in the scan), if there are any. Errors:
  /// kDegenerate for fewer than 10 points.
  static Result<std::shared_ptr<const ScanTarget>> Prepare(
      const TriangleMesh& scan, const std::vector<Eigen::Vector3d>& camera_centers = {});

  const OrientedPoints& points() const { return points_; }
  const PointTree& tree() const { return tree_; }
  /// Whether normals point to the side that was seen; otherwise their sign means nothing.
  bool normals_face_out() const { return normals_face_out_; }

 private:
  ScanTarget(OrientedPoints points, PointTree tree, bool normals_face_out)
      : points_(std::move(points)), tree_(std::move(tree)), normals_face_out_(normals_face_out) {}

  OrientedPoints points_;
  PointTree tree_;
  bool normals_face_out_;
};

/// The first point, by index, of each cube of `voxel_m`, at most `max_count` of them (evenly spread
/// over the rest where there are more).
std::vector<int> VoxelSample(const std::vector<Eigen::Vector3f>& points, float voxel_m,
                             std::size_t max_count);

/// Those points, in that order.
OrientedPoints Select(const OrientedPoints& points, const std::vector<int>& indices);

}  // namespace plumbline
