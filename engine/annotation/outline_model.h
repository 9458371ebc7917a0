// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "engine/base/result.h"
#include "engine/geometry/closest_triangle.h"
#include "engine/geometry/mesh.h"
#include "engine/vision/model_lines.h"

namespace plumbline {

struct OutlineModelOptions {
  double crease_angle_deg = 40;  ///< Between faces that make a crease.
  /// Connected creases shorter than this, in bounding radii, are a scan's noise and left out.
  double min_crease_length = 0.3;
};

/// A model made ready for drawing its outline from anywhere: its edges, which of them are creases,
/// and rays. Immutable; share it.
class OutlineModel {
 public:
  struct Edge {
    int begin = 0, end = 0;             ///< Vertices.
    int opposite = -1, opposite2 = -1;  ///< Third corners of its faces; -1: an open border.
    bool crease = false;
  };

  /// Errors: kDegenerate for a mesh without triangles (a point cloud).
  static Result<std::shared_ptr<const OutlineModel>> Prepare(
      const TriangleMesh& mesh, const OutlineModelOptions& options = {});

  const std::vector<Eigen::Vector3f>& vertices() const { return mesh_.vertices; }  ///< Welded.
  const std::vector<Edge>& edges() const { return edges_; }
  const Eigen::Vector3f& center() const { return center_; }  ///< Of the bounding sphere.
  float radius() const { return radius_; }
  const RayScene& rays() const { return *rays_; }
  const ClosestTriangleSearch& surface() const { return *surface_; }

 private:
  OutlineModel() = default;
  void FindEdges();
  void FindCreases(const OutlineModelOptions& options);

  TriangleMesh mesh_;
  std::vector<Edge> edges_;
  Eigen::Vector3f center_{0, 0, 0};
  float radius_ = 0;
  std::unique_ptr<const RayScene> rays_;
  std::unique_ptr<const ClosestTriangleSearch> surface_;
};

}  // namespace plumbline
