// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plumbline {

/// An indexed triangle mesh or, without triangles, a point cloud. Attribute arrays are empty or as
/// long as `vertices`.
struct TriangleMesh {
  std::vector<Eigen::Vector3f> vertices;  ///< [m] once in the database
  std::vector<Eigen::Vector3i> triangles;
  std::vector<Eigen::Vector3f> normals;
  std::vector<std::array<std::uint8_t, 3>> colors;  ///< RGB
  std::vector<Eigen::Vector2f> texture_coordinates;
  std::string texture_file;  ///< "" without one

  bool empty() const { return vertices.empty(); }
};

/// Rec. 601, as a camera's grey; 0 .. 1.
inline float Luminance(const std::array<std::uint8_t, 3>& rgb) {
  return (0.299f * rgb[0] + 0.587f * rgb[1] + 0.114f * rgb[2]) / 255.0f;
}

/// Bounding box of all vertices; empty box for an empty mesh.
Eigen::AlignedBox3f BoundingBox(const TriangleMesh& mesh);

/// Vertices (and normals) mapped through `target_from_mesh`.
TriangleMesh Transformed(TriangleMesh mesh, const Eigen::Isometry3d& target_from_mesh);

/// Everything times `factor`, about the origin.
TriangleMesh Scaled(TriangleMesh mesh, double factor);
inline Eigen::AlignedBox3d Scaled(const Eigen::AlignedBox3f& box, double factor) {
  return {factor * box.min().cast<double>(), factor * box.max().cast<double>()};
}

/// Appends b's vertices and triangles to a; attributes that only one of them has are dropped.
void Append(const TriangleMesh& b, TriangleMesh& a);

/// Area-weighted vertex normals, unit length; (0,0,1) for vertices without a face of positive area.
void ComputeNormals(TriangleMesh& mesh);

}  // namespace plumbline
