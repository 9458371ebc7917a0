// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "engine/geometry/mesh.h"

namespace plumbline {

/// Posed meshes as one, and which object each triangle belongs to.
struct PosedScene {
  TriangleMesh mesh;
  std::vector<int> object_of_triangle;

  /// @param scale  Times as large as `model`.
  void Add(const TriangleMesh& model, const Eigen::Isometry3d& scene_from_object, double scale,
           int object) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const Eigen::Vector3f& vertex : model.vertices) {
      mesh.vertices.push_back((scene_from_object * (scale * vertex.cast<double>())).cast<float>());
    }
    for (const Eigen::Vector3i& triangle : model.triangles) {
      mesh.triangles.push_back(triangle.array() + first);
      object_of_triangle.push_back(object);
    }
  }
};

}  // namespace plumbline
