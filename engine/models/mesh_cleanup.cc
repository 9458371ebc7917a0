// SPDX-License-Identifier: Apache-2.0
#include "engine/models/mesh_cleanup.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

namespace plumbline {
namespace {

/// What must agree for two vertices to be one: the cell of a fine grid, colour, texture
/// coordinates.
using VertexKey = std::array<std::int64_t, 6>;

struct HashKey {
  std::size_t operator()(const VertexKey& key) const {
    std::size_t hash = 0;
    for (const std::int64_t value : key)
      hash = hash * 0x9E3779B97F4A7C15u + static_cast<std::size_t>(value);
    return hash;
  }
};

VertexKey KeyOf(const TriangleMesh& mesh, std::size_t i, double cell, bool with_attributes) {
  VertexKey key{};
  for (int c = 0; c < 3; ++c) {
    key[static_cast<std::size_t>(c)] =
        std::llround(static_cast<double>(mesh.vertices[i][c]) / cell);
  }
  if (!with_attributes) return key;
  if (!mesh.colors.empty())
    key[3] = mesh.colors[i][0] | mesh.colors[i][1] << 8 | mesh.colors[i][2] << 16;
  if (!mesh.texture_coordinates.empty()) {
    key[4] = std::bit_cast<std::int32_t>(mesh.texture_coordinates[i].x());
    key[5] = std::bit_cast<std::int32_t>(mesh.texture_coordinates[i].y());
  }
  return key;
}

/// For every vertex the first one that it is the same as.
std::vector<int> FirstOfEach(const TriangleMesh& mesh, bool with_attributes) {
  const double diagonal = static_cast<double>(BoundingBox(mesh).diagonal().norm());
  const double cell = diagonal > 0 ? 1e-6 * diagonal : 1.0;
  std::unordered_map<VertexKey, int, HashKey> first;
  first.reserve(mesh.vertices.size());
  std::vector<int> same_as(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    same_as[i] =
        first.try_emplace(KeyOf(mesh, i, cell, with_attributes), static_cast<int>(i)).first->second;
  }
  return same_as;
}

bool IsDegenerate(const TriangleMesh& mesh, const Eigen::Vector3i& t) {
  if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return true;
  const Eigen::Vector3d a = mesh.vertices[static_cast<std::size_t>(t[0])].cast<double>();
  const Eigen::Vector3d ab = mesh.vertices[static_cast<std::size_t>(t[1])].cast<double>() - a;
  const Eigen::Vector3d ac = mesh.vertices[static_cast<std::size_t>(t[2])].cast<double>() - a;
  const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()});
  return ab.cross(ac).norm() <= 1e-9 * longest;
}

template <typename T>
void Keep(const std::vector<int>& kept, std::vector<T>& values) {
  if (values.empty()) return;
  std::vector<T> result;
  result.reserve(kept.size());
  for (const int i : kept) result.push_back(values[static_cast<std::size_t>(i)]);
  values = std::move(result);
}

/// Drops the vertices that no face names; returns how many.
int DropUnreferenced(TriangleMesh& mesh) {
  std::vector<int> new_index(mesh.vertices.size(), -1), kept;
  for (const Eigen::Vector3i& triangle : mesh.triangles) {
    for (const int corner : triangle) new_index[static_cast<std::size_t>(corner)] = 0;
  }
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] < 0) continue;
    new_index[i] = static_cast<int>(kept.size());
    kept.push_back(static_cast<int>(i));
  }
  for (Eigen::Vector3i& triangle : mesh.triangles) {
    for (int& corner : triangle) corner = new_index[static_cast<std::size_t>(corner)];
  }
  const int dropped = static_cast<int>(mesh.vertices.size() - kept.size());
  Keep(kept, mesh.vertices);
  Keep(kept, mesh.colors);
  Keep(kept, mesh.texture_coordinates);
  return dropped;
}

TriangleMesh Clean(TriangleMesh mesh, bool with_attributes, CleanupReport& report) {
  mesh.normals.clear();
  const std::vector<int> same_as = FirstOfEach(mesh, with_attributes);
  for (std::size_t i = 0; i < same_as.size(); ++i)
    report.merged_vertices += same_as[i] != static_cast<int>(i);
  std::set<std::array<int, 3>> seen;
  std::vector<Eigen::Vector3i> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const Eigen::Vector3i& old : mesh.triangles) {
    const Eigen::Vector3i triangle =
        old.unaryExpr([&](int i) { return same_as[static_cast<std::size_t>(i)]; });
    std::array<int, 3> corners = {triangle[0], triangle[1], triangle[2]};
    std::sort(corners.begin(), corners.end());
    if (IsDegenerate(mesh, triangle)) {
      ++report.degenerate_faces;
    } else if (!seen.insert(corners).second) {
      ++report.duplicate_faces;
    } else {
      triangles.push_back(triangle);
    }
  }
  mesh.triangles = std::move(triangles);
  // Merged vertices are unreferenced now too, but counted once.
  report.unreferenced_vertices += DropUnreferenced(mesh) - report.merged_vertices;
  return mesh;
}

}  // namespace

TriangleMesh CleanMesh(const TriangleMesh& mesh, CleanupReport& report) {
  report = {};
  return Clean(mesh, true, report);
}

TriangleMesh WeldedGeometry(const TriangleMesh& mesh) {
  TriangleMesh geometry;
  geometry.vertices = mesh.vertices;
  geometry.triangles = mesh.triangles;
  CleanupReport unused;
  return Clean(std::move(geometry), false, unused);
}

std::vector<int> FirstAtEachPlace(const TriangleMesh& mesh) { return FirstOfEach(mesh, false); }

EdgeCounts CountEdges(const TriangleMesh& mesh) {
  const TriangleMesh welded = WeldedGeometry(mesh);
  std::map<std::pair<int, int>, int> faces_of;
  for (const Eigen::Vector3i& t : welded.triangles) {
    for (int c = 0; c < 3; ++c) ++faces_of[std::minmax({t[c], t[(c + 1) % 3]})];
  }
  EdgeCounts counts;
  for (const auto& [edge, faces] : faces_of) {
    counts.open += faces == 1;
    counts.non_manifold += faces > 2;
  }
  return counts;
}

}  // namespace plumbline
