// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>
#include <utility>

#include "engine/geometry/mesh.h"

namespace plumbline {

/// A box with its corners at `min` and `max`; 12 faces, outward normals by winding.
inline TriangleMesh MakeBox(const Eigen::Vector3f& min, const Eigen::Vector3f& max) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1) ? max.x() : min.x(), (i & 2) ? max.y() : min.y(),
                               (i & 4) ? max.z() : min.z());
  }
  mesh.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                    {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return mesh;
}

/// A sphere about the origin, `rings` from pole to pole and twice as many around; poles on the z
/// axis.
inline TriangleMesh MakeSphere(float radius, int rings) {
  TriangleMesh mesh;
  const int around = 2 * rings;
  for (int i = 0; i <= rings; ++i) {
    const double polar = std::numbers::pi * i / rings;
    for (int j = 0; j < around; ++j) {
      const double azimuth = 2 * std::numbers::pi * j / around;
      mesh.vertices.push_back(
          (radius * Eigen::Vector3d(std::sin(polar) * std::cos(azimuth),
                                    std::sin(polar) * std::sin(azimuth), std::cos(polar)))
              .cast<float>());
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const int a = i * around + j, b = i * around + (j + 1) % around;
      if (i > 0) mesh.triangles.emplace_back(a, a + around, b);
      if (i + 1 < rings) mesh.triangles.emplace_back(b, a + around, b + around);
    }
  }
  return mesh;
}

/// A parallelogram: corner, corner + a, corner + a + b, corner + b.
inline TriangleMesh MakeParallelogram(const Eigen::Vector3f& corner, const Eigen::Vector3f& a,
                                      const Eigen::Vector3f& b) {
  TriangleMesh mesh;
  mesh.vertices = {corner, corner + a, corner + a + b, corner + b};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

/// A finely meshed patch: `steps` squares along each side.
inline TriangleMesh MakeGrid(const Eigen::Vector3f& corner, const Eigen::Vector3f& a,
                             const Eigen::Vector3f& b, int steps) {
  TriangleMesh mesh;
  for (int i = 0; i <= steps; ++i) {
    for (int k = 0; k <= steps; ++k) {
      mesh.vertices.push_back(corner + static_cast<float>(i) / static_cast<float>(steps) * a +
                              static_cast<float>(k) / static_cast<float>(steps) * b);
      if (i == steps || k == steps) continue;
      const int at = i * (steps + 1) + k;
      mesh.triangles.emplace_back(at, at + 1, at + steps + 1);
      mesh.triangles.emplace_back(at + 1, at + steps + 2, at + steps + 1);
    }
  }
  return mesh;
}

/// A finely meshed box without a bottom; it stands on the origin.
inline TriangleMesh MakeFineBox(const Eigen::Vector3f& size) {
  const Eigen::Vector3f a(size.x(), 0, 0), b(0, size.y(), 0), c(0, 0, size.z()),
      low(-size.x() / 2, -size.y() / 2, 0);
  TriangleMesh box = MakeGrid(low + c, a, b, 20);
  for (const auto& [corner, side] :
       {std::pair(low, a), {low + a, b}, {low + a + b, -a}, {low + b, -b}}) {
    Append(MakeGrid(corner, side, c, 20), box);
  }
  return box;
}

}  // namespace plumbline
