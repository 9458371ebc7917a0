// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/light_map.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <unordered_map>

namespace plumbline {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
constexpr float kPi = std::numbers::pi_v<float>;
constexpr int kMaxSteps = 48;
constexpr float kLiftM = 1e-3f;

/// Points with nearly the same place and normal share their light; the cell is small against the
/// spacing.
std::uint64_t CellKey(const Vector3f& position, const Vector3f& normal) {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    key =
        key * 1000003 + static_cast<std::uint64_t>(std::llround(position[axis] / 0.004f) + 100000);
  }
  for (int axis = 0; axis < 3; ++axis) {
    key = key * 1000003 + static_cast<std::uint64_t>(std::llround(normal[axis] * 5) + 10);
  }
  return key;
}

/// The R2 sequence (M. Roberts): evenly spread points of the unit square.
Vector2f SpreadPoint(int i) {
  const double u = 0.5 + 0.7548776662466927 * i, v = 0.5 + 0.5698402909980532 * i;
  return {static_cast<float>(u - std::floor(u)), static_cast<float>(v - std::floor(v))};
}

Vector2f DiskPoint(const Vector2f& square) {
  const float radius = std::sqrt(square.x()), angle = 2 * kPi * square.y();
  return {radius * std::cos(angle), radius * std::sin(angle)};
}

Eigen::Matrix3f FrameAround(const Vector3f& axis) {
  const Vector3f helper = std::abs(axis.z()) < 0.95f ? Vector3f::UnitZ() : Vector3f::UnitX();
  Eigen::Matrix3f frame;
  frame.col(0) = helper.cross(axis).normalized();
  frame.col(1) = axis.cross(frame.col(0));
  frame.col(2) = axis;
  return frame;
}

/// Light that reaches one point straight from the lights and the sun.
Vector3f DirectLight(const TracedScene& scene, std::span<const AreaLight> lights,
                     const std::optional<SunLight>& sun, int rays, const Vector3f& position,
                     const Vector3f& normal) {
  Vector3f sum = Vector3f::Zero();
  for (const AreaLight& light : lights) {
    const Vector3f area = light.u.cross(light.v);
    const Vector3f facing = area.normalized();
    float seen = 0;
    for (int i = 0; i < rays; ++i) {
      const Vector2f at = SpreadPoint(i);
      const Vector3f to_light = light.corner + at.x() * light.u + at.y() * light.v - position;
      const float distance = to_light.norm();
      const Vector3f direction = to_light / distance;
      const float cosines =
          std::max(0.0f, normal.dot(direction)) * std::max(0.0f, -facing.dot(direction));
      if (cosines <= 0 || scene.Blocked(position, direction, distance * 0.999f)) continue;
      seen += cosines / (distance * distance);
    }
    sum += light.radiance * (seen * area.norm() / (kPi * static_cast<float>(rays)));
  }
  if (sun && normal.dot(sun->to_sun) > -sun->radius) {
    const Eigen::Matrix3f frame = FrameAround(sun->to_sun);
    const int sun_rays = std::max(1, rays / 2);
    float seen = 0;
    for (int i = 0; i < sun_rays; ++i) {
      const Vector2f disk = DiskPoint(SpreadPoint(i)) * sun->radius;
      const Vector3f direction = (frame * Vector3f(disk.x(), disk.y(), 1)).normalized();
      const float cosine = normal.dot(direction);
      if (cosine > 0 && !scene.Blocked(position, direction, 100)) seen += cosine;
    }
    sum += sun->irradiance * (seen / static_cast<float>(sun_rays));
  }
  return sum;
}

int Row(int steps, int j) { return j * (steps + 1) - j * (j - 1) / 2; }

}  // namespace

std::vector<LightMap::Point> LightMap::PlacePoints(const TracedScene& scene) {
  std::vector<Point> points;
  std::unordered_map<std::uint64_t, std::uint32_t> known;
  const auto& vertices = scene.vertices();
  lattices_.reserve(scene.triangles().size());
  for (std::size_t t = 0; t < scene.triangles().size(); ++t) {
    const TracedScene::Triangle& triangle = scene.triangles()[t];
    std::array<Vector3f, 3> corner;
    for (int k = 0; k < 3; ++k) corner[k] = vertices[static_cast<std::size_t>(triangle.corners[k])];
    const float longest = std::max({(corner[1] - corner[0]).norm(), (corner[2] - corner[1]).norm(),
                                    (corner[0] - corner[2]).norm()});
    const int steps =
        triangle.lets_light_in
            ? 1
            : std::clamp(static_cast<int>(std::ceil(longest / triangle.light_spacing_m)), 1,
                         kMaxSteps);
    const Vector3f middle = (corner[0] + corner[1] + corner[2]) / 3;
    lattices_.push_back({static_cast<std::uint32_t>(indices_.size()), steps});
    for (int j = 0; j <= steps; ++j) {
      for (int i = 0; i + j <= steps; ++i) {
        const float u = static_cast<float>(i) / static_cast<float>(steps);
        const float v = static_cast<float>(j) / static_cast<float>(steps);
        const Vector3f position =
            corner[0] + u * (corner[1] - corner[0]) + v * (corner[2] - corner[0]);
        const Vector3f normal = scene.ShadingNormal({static_cast<std::uint32_t>(t), 0, u, v});
        const auto [entry, fresh] =
            known.try_emplace(CellKey(position, normal), static_cast<std::uint32_t>(points.size()));
        if (fresh) {
          // A little inwards: a point on an edge would look past the neighbouring wall.
          const Vector3f inwards = middle - position;
          const float step = std::min(0.3f * inwards.norm(), 0.002f);
          points.push_back({position + inwards.normalized() * step + kLiftM * normal, normal});
        }
        indices_.push_back(entry->second);
      }
    }
  }
  return points;
}

Result<LightMap> LightMap::Compute(const TracedScene& scene, std::span<const AreaLight> lights,
                                   const std::optional<SunLight>& sun, int rays,
                                   const WorkContext& context) {
  LightMap map;
  const std::vector<Point> points = map.PlacePoints(scene);
  std::vector<Vector3f> direct(points.size());
  map.light_.assign(points.size(), Vector3f::Zero());
  constexpr std::size_t kBatch = 8192;
  constexpr int kPasses = 3;
  const int total = static_cast<int>((points.size() + kBatch - 1) / kBatch) * kPasses;
  int done = 0;
  std::vector<Vector3f> hemisphere(static_cast<std::size_t>(rays));
  for (int i = 0; i < rays; ++i) {
    const Vector2f disk = DiskPoint(SpreadPoint(i));
    hemisphere[static_cast<std::size_t>(i)] = {disk.x(), disk.y(),
                                               std::sqrt(std::max(0.0f, 1 - disk.squaredNorm()))};
  }
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<Vector3f> next(points.size());
    for (std::size_t begin = 0; begin < points.size(); begin += kBatch) {
      if (context.stop.stop_requested())
        return Error{ErrorCode::kCancelled, "stopped while computing the light"};
      context.report({"light", done++, total});
      tbb::parallel_for(
          tbb::blocked_range<std::size_t>(begin, std::min(begin + kBatch, points.size()), 256),
          [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t i = range.begin(); i < range.end(); ++i) {
              if (pass == 0) {
                direct[i] = DirectLight(scene, lights, sun, std::max(4, rays / 3),
                                        points[i].position, points[i].normal);
                next[i] = direct[i];
                continue;
              }
              const Eigen::Matrix3f frame = FrameAround(points[i].normal);
              Vector3f sum = Vector3f::Zero();
              for (const Vector3f& local : hemisphere) {
                const TracedScene::Hit hit = scene.Trace(points[i].position, frame * local);
                if (!hit.valid()) continue;
                const TracedScene::Triangle& triangle = scene.triangles()[hit.triangle];
                if (triangle.lets_light_in) continue;  // counted as direct light
                const float emission = scene.material(triangle).emission;
                sum += triangle.mean_color.cwiseProduct(map.At(hit) + Vector3f::Constant(emission));
              }
              next[i] = direct[i] + sum / static_cast<float>(rays);
            }
          });
    }
    map.light_ = std::move(next);
  }
  return map;
}

Vector3f LightMap::At(const TracedScene::Hit& hit) const {
  const Lattice& lattice = lattices_[hit.triangle];
  const int steps = lattice.steps;
  const float x = std::clamp(hit.u, 0.0f, 1.0f) * static_cast<float>(steps);
  const float y = std::clamp(hit.v, 0.0f, 1.0f) * static_cast<float>(steps);
  const int j = std::min(static_cast<int>(y), steps - 1);
  const int i = std::min(static_cast<int>(x), steps - 1 - j);
  const float dx = std::clamp(x - static_cast<float>(i), 0.0f, 1.0f);
  const float dy = std::clamp(y - static_cast<float>(j), 0.0f, 1.0f);
  const auto at = [&](int column, int row) {
    return light_[indices_[lattice.first + static_cast<std::uint32_t>(Row(steps, row) + column)]];
  };
  if (dx + dy <= 1 || i + j + 2 > steps) {
    const float weight = std::max(0.0f, 1 - dx - dy);
    return (at(i, j) * weight + at(i + 1, j) * dx + at(i, j + 1) * dy) / (weight + dx + dy);
  }
  return at(i + 1, j + 1) * (dx + dy - 1) + at(i + 1, j) * (1 - dy) + at(i, j + 1) * (1 - dx);
}

float LightMap::MeanLuminance() const {
  double sum = 0;
  for (const Vector3f& light : light_) sum += light.dot(Vector3f(0.2126f, 0.7152f, 0.0722f));
  return light_.empty() ? 0 : static_cast<float>(sum / static_cast<double>(light_.size()));
}

}  // namespace plumbline
