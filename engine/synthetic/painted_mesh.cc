// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/painted_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "engine/base/check.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
using Eigen::Vector3i;

int AddVertex(PaintedMesh& mesh, const Vector3f& position, const Vector3f& normal,
              const Vector3f& texture) {
  mesh.vertices.push_back(position);
  mesh.normals.push_back(normal);
  mesh.texture.push_back(texture);
  return static_cast<int>(mesh.vertices.size()) - 1;
}

/// Leaves out triangles without area (poles, zero radii).
void AddTriangle(PaintedMesh& mesh, int paint, int a, int b, int c) {
  const Vector3f doubled =
      (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
  if (doubled.norm() < 1e-10f) return;
  mesh.triangles.emplace_back(a, b, c);
  mesh.paints.push_back(paint);
}

/// Triangles of a rows x columns grid of vertices starting at `first`.
void AddGrid(PaintedMesh& mesh, int paint, int first, int rows, int columns) {
  for (int r = 0; r + 1 < rows; ++r) {
    for (int c = 0; c + 1 < columns; ++c) {
      const int a = first + r * columns + c;
      AddTriangle(mesh, paint, a, a + 1, a + columns + 1);
      AddTriangle(mesh, paint, a, a + columns + 1, a + columns);
    }
  }
}

/// One step of a box's side: the offset of the core's point and the angle of the rounding there.
struct BoxLine {
  float core;
  float angle;
};

std::vector<BoxLine> BoxLines(float half_core, int arc, int divisions) {
  std::vector<BoxLine> lines;
  for (int i = 0; i < arc; ++i) {
    lines.push_back(
        {-half_core, -kPiF / 4 * static_cast<float>(arc - i) / static_cast<float>(arc)});
  }
  for (int i = 0; i <= divisions; ++i) {
    lines.push_back(
        {half_core * (2.0f * static_cast<float>(i) / static_cast<float>(divisions) - 1), 0});
  }
  for (int i = 1; i <= arc; ++i) {
    lines.push_back({half_core, kPiF / 4 * static_cast<float>(i) / static_cast<float>(arc)});
  }
  return lines;
}

/// Cross-section frames carried along a path without twist.
struct PathFrame {
  Vector3f along, side, up;
};

std::vector<PathFrame> FramesAlong(const std::vector<Vector3f>& path) {
  std::vector<PathFrame> frames(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vector3f& before = path[i == 0 ? 0 : i - 1];
    const Vector3f& after = path[std::min(i + 1, path.size() - 1)];
    frames[i].along = (after - before).normalized();
    Vector3f side;
    if (i == 0) {
      const Vector3f helper =
          std::abs(frames[0].along.x()) < 0.9f ? Vector3f::UnitX() : Vector3f::UnitY();
      side = helper - frames[0].along * helper.dot(frames[0].along);
    } else {
      side = frames[i - 1].side - frames[i].along * frames[i - 1].side.dot(frames[i].along);
    }
    frames[i].side = side.normalized();
    frames[i].up = frames[i].along.cross(frames[i].side);
  }
  return frames;
}

}  // namespace

void AddBox(PaintedMesh& mesh, int paint, const BoxShape& shape) {
  const float radius = std::min(shape.radius, 0.4999f * shape.size.minCoeff());
  const Vector3f half_core = shape.size / 2 - Vector3f::Constant(radius);
  int grain = shape.grain;
  if (grain < 0) shape.size.maxCoeff(&grain);
  for (int axis = 0; axis < 3; ++axis) {
    const int axis_u = (axis + 1) % 3, axis_v = (axis + 2) % 3;
    for (const float sign : {-1.0f, 1.0f}) {
      const auto rows = BoxLines(half_core[axis_v], shape.arc, shape.divisions[axis_v]);
      auto columns = BoxLines(half_core[axis_u], shape.arc, shape.divisions[axis_u]);
      if (sign < 0) std::reverse(columns.begin(), columns.end());
      const int first = static_cast<int>(mesh.vertices.size());
      for (const BoxLine& row : rows) {
        for (const BoxLine& column : columns) {
          Vector3f core, normal;
          core[axis] = sign * half_core[axis];
          core[axis_u] = column.core;
          core[axis_v] = row.core;
          normal[axis] = sign;
          normal[axis_u] = std::tan(column.angle);
          normal[axis_v] = std::tan(row.angle);
          normal.normalize();
          const Vector3f local = core + radius * normal;
          AddVertex(mesh, shape.center + shape.rotation * local, shape.rotation * normal,
                    {local[grain], local[(grain + 1) % 3], local[(grain + 2) % 3]});
        }
      }
      AddGrid(mesh, paint, first, static_cast<int>(rows.size()), static_cast<int>(columns.size()));
    }
  }
}

void AddLathe(PaintedMesh& mesh, int paint, const Vector3f& origin,
              const std::vector<Vector2f>& profile, int segments) {
  PLB_CHECK(profile.size() >= 2 && segments >= 3);
  const auto span_normal = [&](std::size_t i) {
    const Vector2f d = profile[i + 1] - profile[i];
    return Vector2f(d.y(), -d.x()).normalized();
  };
  float length = 0;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    const float next_length = length + (profile[i + 1] - profile[i]).norm();
    const Vector2f flat = span_normal(i);
    const auto shared_normal = [&](std::size_t neighbour) {
      const Vector2f other = span_normal(neighbour);
      if (other.dot(flat) < std::cos(35 * kPiF / 180)) return flat;
      return Vector2f((other + flat).normalized());
    };
    const Vector2f low = shared_normal(i == 0 ? i : i - 1);
    const Vector2f high = shared_normal(i + 2 < profile.size() ? i + 1 : i);
    const int first = static_cast<int>(mesh.vertices.size());
    for (int row = 0; row < 2; ++row) {
      const Vector2f& p = profile[i + row];
      const Vector2f& n = row == 0 ? low : high;
      for (int s = 0; s <= segments; ++s) {
        const float angle =
            2 * kPiF * static_cast<float>(s % segments) / static_cast<float>(segments);
        const Vector3f radial(std::cos(angle), std::sin(angle), 0);
        const float around = 2 * kPiF * static_cast<float>(s) / static_cast<float>(segments);
        AddVertex(mesh, origin + radial * p.x() + Vector3f(0, 0, p.y()),
                  (radial * n.x() + Vector3f(0, 0, n.y())).normalized(),
                  {row == 0 ? length : next_length, around * p.x(), 0});
      }
    }
    AddGrid(mesh, paint, first, 2, segments + 1);
    length = next_length;
  }
}

void AddTube(PaintedMesh& mesh, int paint, const std::vector<Vector3f>& path,
             const std::vector<float>& radii, int sides) {
  PLB_CHECK(path.size() >= 2 && (radii.size() == 1 || radii.size() == path.size()));
  const std::vector<PathFrame> frames = FramesAlong(path);
  const auto ring = [&](std::size_t i, int s) {
    const float angle = 2 * kPiF * static_cast<float>(s % sides) / static_cast<float>(sides);
    return Vector3f(frames[i].side * std::cos(angle) + frames[i].up * std::sin(angle));
  };
  const auto radius = [&](std::size_t i) { return radii.size() == 1 ? radii[0] : radii[i]; };
  const int first = static_cast<int>(mesh.vertices.size());
  float length = 0;
  for (std::size_t i = 0; i < path.size(); ++i) {
    if (i > 0) length += (path[i] - path[i - 1]).norm();
    for (int s = 0; s <= sides; ++s) {
      AddVertex(
          mesh, path[i] + ring(i, s) * radius(i), ring(i, s),
          {length, 2 * kPiF * radius(i) * static_cast<float>(s) / static_cast<float>(sides), 0});
    }
  }
  AddGrid(mesh, paint, first, static_cast<int>(path.size()), sides + 1);
  for (const std::size_t end : {std::size_t{0}, path.size() - 1}) {
    const float sign = end == 0 ? -1.0f : 1.0f;
    const Vector3f normal = sign * frames[end].along;
    const int center = AddVertex(mesh, path[end], normal, Vector3f::Zero());
    for (int s = 0; s <= sides; ++s) {
      const Vector3f offset = ring(end, s) * radius(end);
      AddVertex(mesh, path[end] + offset, normal, {0, offset.x(), offset.y()});
    }
    for (int s = 0; s < sides; ++s) {
      const int a = center + 1 + s;
      AddTriangle(mesh, paint, center, sign > 0 ? a : a + 1, sign > 0 ? a + 1 : a);
    }
  }
}

void AddQuad(PaintedMesh& mesh, int paint, const Vector3f& corner, const Vector3f& u,
             const Vector3f& v) {
  const Vector3f normal = u.cross(v).normalized();
  const int first = AddVertex(mesh, corner, normal, {0, 0, 0});
  AddVertex(mesh, corner + u, normal, {u.norm(), 0, 0});
  AddVertex(mesh, corner + v, normal, {0, v.norm(), 0});
  AddVertex(mesh, corner + u + v, normal, {u.norm(), v.norm(), 0});
  AddGrid(mesh, paint, first, 2, 2);
}

std::vector<Vector3f> SmoothPath(const std::vector<Vector3f>& points, int per_span) {
  std::vector<Vector3f> path;
  const int n = static_cast<int>(points.size());
  const auto at = [&](int i) { return points[static_cast<std::size_t>(std::clamp(i, 0, n - 1))]; };
  for (int i = 0; i + 1 < n; ++i) {
    for (int k = 0; k < per_span; ++k) {
      const float t = static_cast<float>(k) / static_cast<float>(per_span);
      const Vector3f a = at(i - 1), b = at(i), c = at(i + 1), d = at(i + 2);
      path.push_back(0.5f * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t +
                             (3 * b - a - 3 * c + d) * t * t * t));
    }
  }
  path.push_back(points.back());
  return path;
}

void Deform(PaintedMesh& mesh, std::size_t first,
            const std::function<Vector3f(const Vector3f&)>& map) {
  constexpr float kStep = 1e-3f;
  for (std::size_t i = first; i < mesh.vertices.size(); ++i) {
    const Vector3f& p = mesh.vertices[i];
    Eigen::Matrix3f jacobian;
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3f step = kStep * Vector3f::Unit(axis);
      jacobian.col(axis) = (map(p + step) - map(p - step)) / (2 * kStep);
    }
    mesh.normals[i] = (jacobian.inverse().transpose() * mesh.normals[i]).normalized();
    mesh.vertices[i] = map(p);
  }
}

void AppendPainted(const PaintedMesh& b, const Eigen::Isometry3f& a_from_b, int paint_offset,
                   PaintedMesh& a) {
  const int offset = static_cast<int>(a.vertices.size());
  for (std::size_t i = 0; i < b.vertices.size(); ++i) {
    AddVertex(a, a_from_b * b.vertices[i], a_from_b.linear() * b.normals[i], b.texture[i]);
  }
  for (std::size_t i = 0; i < b.triangles.size(); ++i) {
    a.triangles.push_back(b.triangles[i] + Vector3i::Constant(offset));
    a.paints.push_back(b.paints[i] + paint_offset);
  }
}

void Refine(PaintedMesh& mesh, float max_edge_m) {
  std::map<std::pair<int, int>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto key = std::minmax(a, b);
    const auto found = middles.find(key);
    if (found != middles.end()) return found->second;
    const int index = AddVertex(mesh, (mesh.vertices[a] + mesh.vertices[b]) / 2,
                                (mesh.normals[a] + mesh.normals[b]).normalized(),
                                (mesh.texture[a] + mesh.texture[b]) / 2);
    middles.emplace(key, index);
    return index;
  };
  for (std::size_t t = 0; t < mesh.triangles.size();) {
    const Vector3i corners = mesh.triangles[t];
    int longest = 0;
    float length = 0;
    for (int k = 0; k < 3; ++k) {
      const float edge = (mesh.vertices[corners[k]] - mesh.vertices[corners[(k + 1) % 3]]).norm();
      if (edge > length) {
        length = edge;
        longest = k;
      }
    }
    if (length <= max_edge_m) {
      ++t;
      continue;
    }
    const int a = corners[longest], b = corners[(longest + 1) % 3], c = corners[(longest + 2) % 3];
    const int m = middle(a, b);
    mesh.triangles[t] = {a, m, c};
    mesh.triangles.emplace_back(m, b, c);
    mesh.paints.push_back(mesh.paints[t]);
  }
}

}  // namespace plumbline
