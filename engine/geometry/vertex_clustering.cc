// SPDX-License-Identifier: Apache-2.0
#include "engine/geometry/vertex_clustering.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "engine/base/check.h"

namespace plumbline {
namespace {

constexpr std::int64_t kCellsPerAxis = std::int64_t{1} << 21;  // three of them fit into 63 bits

std::int64_t CellOf(const Eigen::Vector3f& point, const Eigen::Vector3f& origin, double cell_m) {
  std::int64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto index =
        static_cast<std::int64_t>(static_cast<double>(point[axis] - origin[axis]) / cell_m);
    key = key * kCellsPerAxis + std::clamp<std::int64_t>(index, 0, kCellsPerAxis - 1);
  }
  return key;
}

Eigen::Vector3f Normal(const TriangleMesh& mesh, const Eigen::Vector3i& t) {
  const auto& v = mesh.vertices;
  return (v[t[1]] - v[t[0]]).cross(v[t[2]] - v[t[0]]);
}

/// Of the triangles; of a cloud, half its bounding box's surface.
double AreaOf(const TriangleMesh& mesh) {
  double area = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    area += 0.5 * static_cast<double>(Normal(mesh, t).norm());
  }
  if (area > 0) return area;
  const Eigen::Vector3d size = BoundingBox(mesh).sizes().cast<double>();
  return size.x() * size.y() + size.y() * size.z() + size.z() * size.x();
}

}  // namespace

TriangleMesh ClusterVertices(const TriangleMesh& mesh, double cell_m) {
  PLB_CHECK(cell_m > 0) << "cells have a size";
  TriangleMesh result;
  if (mesh.empty()) return result;
  const Eigen::Vector3f origin = BoundingBox(mesh).min();
  const bool colored = mesh.colors.size() == mesh.vertices.size();
  std::unordered_map<std::int64_t, int> cluster_of_cell;
  std::vector<int> cluster(mesh.vertices.size());
  std::vector<int> count;
  std::vector<Eigen::Vector3f> color_sum;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto [entry, is_new] = cluster_of_cell.emplace(CellOf(mesh.vertices[i], origin, cell_m),
                                                         static_cast<int>(count.size()));
    if (is_new) {
      result.vertices.emplace_back(0, 0, 0);
      color_sum.emplace_back(0, 0, 0);
      count.push_back(0);
    }
    const auto c = static_cast<std::size_t>(entry->second);
    cluster[i] = entry->second;
    // Sums relative to the origin keep their digits.
    result.vertices[c] += mesh.vertices[i] - origin;
    ++count[c];
    if (colored)
      color_sum[c] += Eigen::Vector3f(mesh.colors[i][0], mesh.colors[i][1], mesh.colors[i][2]);
  }
  for (std::size_t c = 0; c < count.size(); ++c) {
    result.vertices[c] = result.vertices[c] / static_cast<float>(count[c]) + origin;
    if (!colored) continue;
    const Eigen::Vector3f mean = color_sum[c] / static_cast<float>(count[c]);
    result.colors.push_back({static_cast<std::uint8_t>(mean[0] + 0.5f),
                             static_cast<std::uint8_t>(mean[1] + 0.5f),
                             static_cast<std::uint8_t>(mean[2] + 0.5f)});
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    Eigen::Vector3i merged(cluster[t[0]], cluster[t[1]], cluster[t[2]]);
    if (merged[0] == merged[1] || merged[1] == merged[2] || merged[2] == merged[0]) continue;
    // Moved corners can turn a sliver over; it keeps its side.
    if (Normal(result, merged).dot(Normal(mesh, t)) < 0) std::swap(merged[1], merged[2]);
    // The smallest index first: the same triangle, in the same winding, is then the same triple.
    while (merged[0] > merged[1] || merged[0] > merged[2])
      merged = {merged[1], merged[2], merged[0]};
    result.triangles.push_back(merged);
  }
  const auto less = [](const Eigen::Vector3i& a, const Eigen::Vector3i& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::sort(result.triangles.begin(), result.triangles.end(), less);
  result.triangles.erase(std::unique(result.triangles.begin(), result.triangles.end()),
                         result.triangles.end());
  return result;
}

TriangleMesh ClusterToAbout(const TriangleMesh& mesh, std::size_t vertices) {
  PLB_CHECK(vertices > 0) << "nothing to keep";
  if (mesh.vertices.size() <= vertices) return mesh;
  // A flat surface passes about one cell and a half per cell face of its area.
  double cell_m = std::sqrt(1.5 * std::max(AreaOf(mesh), 1e-6) / static_cast<double>(vertices));
  TriangleMesh result = ClusterVertices(mesh, cell_m);
  if (result.vertices.size() > vertices + vertices / 5) {
    cell_m *=
        std::sqrt(static_cast<double>(result.vertices.size()) / static_cast<double>(vertices));
    result = ClusterVertices(mesh, cell_m);
  }
  return result;
}

}  // namespace plumbline
