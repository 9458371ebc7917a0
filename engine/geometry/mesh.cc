// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/mesh.h"

namespace plumbline {
namespace {
template <typename T>
void AppendAttribute(const std::vector<T>& b, std::size_t b_size, std::vector<T>& a,
                     std::size_t a_size) {
  if (b.size() != b_size || a.size() != a_size) {
    a.clear();
  } else {
    a.insert(a.end(), b.begin(), b.end());
  }
}
}  // namespace

Eigen::AlignedBox3f BoundingBox(const TriangleMesh& mesh) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  return box;
}

TriangleMesh Transformed(TriangleMesh mesh, const Eigen::Isometry3d& target_from_mesh) {
  for (Eigen::Vector3f& vertex : mesh.vertices) {
    vertex = (target_from_mesh * vertex.cast<double>()).cast<float>();
  }
  for (Eigen::Vector3f& normal : mesh.normals) {
    normal = (target_from_mesh.linear() * normal.cast<double>()).cast<float>();
  }
  return mesh;
}

TriangleMesh Scaled(TriangleMesh mesh, double factor) {
  for (Eigen::Vector3f& vertex : mesh.vertices) vertex *= static_cast<float>(factor);
  return mesh;
}

void Append(const TriangleMesh& b, TriangleMesh& a) {
  if (a.empty()) {
    a = b;
    return;
  }
  const int offset = static_cast<int>(a.vertices.size());
  AppendAttribute(b.normals, b.vertices.size(), a.normals, a.vertices.size());
  AppendAttribute(b.colors, b.vertices.size(), a.colors, a.vertices.size());
  AppendAttribute(b.texture_coordinates, b.vertices.size(), a.texture_coordinates,
                  a.vertices.size());
  if (a.texture_coordinates.empty() || a.texture_file != b.texture_file) a.texture_file.clear();
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const Eigen::Vector3i& triangle : b.triangles) {
    a.triangles.push_back(triangle + Eigen::Vector3i::Constant(offset));
  }
}

void ComputeNormals(TriangleMesh& mesh) {
  std::vector<Eigen::Vector3d> sums(mesh.vertices.size(), Eigen::Vector3d::Zero());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>(),
                          b = mesh.vertices[t[1]].cast<double>(),
                          c = mesh.vertices[t[2]].cast<double>();
    const Eigen::Vector3d doubled_area_normal = (b - a).cross(c - a);
    for (int corner = 0; corner < 3; ++corner) sums[t[corner]] += doubled_area_normal;
  }
  mesh.normals.resize(mesh.vertices.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double norm = sums[i].norm();
    mesh.normals[i] = norm > 0 ? (sums[i] / norm).cast<float>().eval() : Eigen::Vector3f(0, 0, 1);
  }
}

}  // namespace plumbline
