// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plumbline {

/// A mesh with shading normals, texture coordinates and a material for every triangle. Vertices are
/// split where the surface has a crease. All shapes below are closed and their triangles turn
/// counter-clockwise seen from outside.
struct PaintedMesh {
  std::vector<Eigen::Vector3f> vertices;  ///< [m]
  std::vector<Eigen::Vector3f> normals;
  std::vector<Eigen::Vector3f> texture;  ///< [m], x runs along the grain
  std::vector<Eigen::Vector3i> triangles;
  std::vector<int> paints;  ///< Material index of each triangle.
};

/// A box with rounded edges.
struct BoxShape {
  Eigen::Vector3f center, size;        ///< [m]
  float radius = 0.004f;               ///< Of edges and corners [m]; cut to half the smallest side.
  int arc = 1;                         ///< Segments of half a rounded edge.
  Eigen::Vector3i divisions{1, 1, 1};  ///< Of the flat part, for boxes that are bent afterwards.
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();
  int grain = -1;  ///< Axis of the texture's x; -1: the longest side.
};
void AddBox(PaintedMesh& mesh, int paint, const BoxShape& shape);

/// A surface of revolution about the vertical axis through `origin`. The profile (radius, height)
/// runs from the bottom to the top of the outside (for a closed body it starts and ends at radius
/// 0); bends over 35 degrees are creases.
void AddLathe(PaintedMesh& mesh, int paint, const Eigen::Vector3f& origin,
              const std::vector<Eigen::Vector2f>& profile, int segments);

/// A round bar along a path, closed by flat caps. `radii` has one entry for all or one for each
/// point.
void AddTube(PaintedMesh& mesh, int paint, const std::vector<Eigen::Vector3f>& path,
             const std::vector<float>& radii, int sides);

/// A rectangle seen from the side that corner, u and v turn counter-clockwise around; texture (|u|,
/// |v|, 0) in metres.
void AddQuad(PaintedMesh& mesh, int paint, const Eigen::Vector3f& corner, const Eigen::Vector3f& u,
             const Eigen::Vector3f& v);

/// A smooth curve through `points` (Catmull-Rom), `per_span` pieces between neighbours.
std::vector<Eigen::Vector3f> SmoothPath(const std::vector<Eigen::Vector3f>& points, int per_span);

/// Moves the vertices from index `first` on by a smooth map; normals follow.
void Deform(PaintedMesh& mesh, std::size_t first,
            const std::function<Eigen::Vector3f(const Eigen::Vector3f&)>& map);

/// Appends `b` moved by `a_from_b`, its paints shifted by `paint_offset`.
void AppendPainted(const PaintedMesh& b, const Eigen::Isometry3f& a_from_b, int paint_offset,
                   PaintedMesh& a);

/// Cuts triangles until no edge is longer than `max_edge_m`; the surface stays the same.
void Refine(PaintedMesh& mesh, float max_edge_m);

}  // namespace plumbline
