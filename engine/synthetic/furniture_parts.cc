// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/furniture_parts.h"

#include <algorithm>
#include <cmath>

#include "engine/geometry/angles.h"

namespace plumbline {

using Eigen::Vector3f;

void AddBar(PaintedMesh& mesh, int paint, const BarShape& shape) {
  const Vector3f axis = shape.to - shape.from;
  const float length = axis.norm();
  const Vector3f along = axis / length;
  const Vector3f helper = std::abs(along.y()) < 0.9f ? Vector3f::UnitY() : Vector3f::UnitX();
  const Vector3f side = (helper - along * helper.dot(along)).normalized();
  Eigen::Matrix3f rotation;
  rotation << side.cross(along), side, along;
  const std::size_t first = mesh.vertices.size();
  const Eigen::Vector2f& wide = shape.start;
  AddBox(mesh, paint,
         {.center = Vector3f::Zero(),
          .size = {wide.x(), wide.y(), length},
          .radius = shape.radius,
          .grain = 2});
  const Eigen::Vector2f ratio = shape.end.cwiseQuotient(shape.start);
  Deform(mesh, first, [&](const Vector3f& p) {
    const float t = p.z() / length + 0.5f;
    const Vector3f tapered(p.x() * (1 + (ratio.x() - 1) * t), p.y() * (1 + (ratio.y() - 1) * t),
                           p.z());
    return Vector3f((shape.from + shape.to) / 2 + rotation * tapered);
  });
}

void AddCushion(PaintedMesh& mesh, int paint, const Vector3f& center, const Vector3f& size,
                float bulge, const Eigen::Matrix3f& rotation) {
  const std::size_t first = mesh.vertices.size();
  AddBox(mesh, paint,
         {.center = Vector3f::Zero(),
          .size = size,
          .radius = 0.3f * size.minCoeff(),
          .arc = 2,
          .divisions = {3, 3, 3}});
  Deform(mesh, first, [&](const Vector3f& p) {
    Vector3f moved;
    for (int axis = 0; axis < 3; ++axis) {
      const int b = (axis + 1) % 3, c = (axis + 2) % 3;
      const float u = 2 * p[b] / size[b], v = 2 * p[c] / size[c];
      moved[axis] =
          p[axis] * (1 + bulge * (1 - u * u) * (1 - v * v) * size.minCoeff() / size[axis]);
    }
    return Vector3f(center + rotation * moved);
  });
}

void AddBlock(PaintedMesh& mesh, int paint, const Vector3f& center, const Vector3f& size,
              float radius, int grain) {
  AddBox(mesh, paint, {.center = center, .size = size, .radius = radius, .grain = grain});
}

void AddLeaf(PaintedMesh& mesh, int paint, const Vector3f& root, float azimuth, float rise,
             float length, float width, const Eigen::Vector2i& divisions) {
  const std::size_t first = mesh.vertices.size();
  AddBox(mesh, paint,
         {.center = {length / 2, 0, 0},
          .size = {length, width, 0.003f},
          .radius = 0.001f,
          .divisions = {divisions.x(), divisions.y(), 1},
          .grain = 0});
  const Eigen::Matrix3f turn = Eigen::AngleAxisf(azimuth, Vector3f::UnitZ()).toRotationMatrix() *
                               Eigen::AngleAxisf(-rise, Vector3f::UnitY()).toRotationMatrix();
  Deform(mesh, first, [&](const Vector3f& p) {
    const float t = p.x() / length;
    const float outline =
        0.08f +
        0.92f * std::pow(std::max(0.0f, std::sin(kPiF * std::clamp(0.12f + 0.85f * t, 0.0f, 1.0f))),
                         0.8f);
    const float fold = 0.35f * std::abs(p.y());
    return Vector3f(root +
                    turn * Vector3f(p.x(), p.y() * outline, p.z() + fold - 0.55f * length * t * t));
  });
}

void StandOnOrigin(PaintedMesh& mesh) {
  Eigen::AlignedBox3f bounds;
  for (const Vector3f& vertex : mesh.vertices) bounds.extend(vertex);
  const Vector3f stand(bounds.center().x(), bounds.center().y(), bounds.min().z());
  for (Vector3f& vertex : mesh.vertices) vertex -= stand;
}

}  // namespace plumbline
