// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/light_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3f;
constexpr int kMaxSteps = 48;
constexpr float kLiftM = 1e-3f;
/// Of the light that comes from other surfaces: it varies slowly, unlike shadows.
constexpr int kSmoothingPasses = 10;
/// Points with another surface this close above them do not show; they take the light of
/// neighbours, or shadows would leak out from under things.
constexpr float kCoveredM = 0.008f;
constexpr int kFillingPasses = 3;

/// Points with nearly the same place and normal share their light; the cell is small against the
/// spacing.
std::uint64_t CellKey(const Vector3f& position, const Vector3f& normal, float spacing_m) {
  const float cell = 0.4f * spacing_m;
  std::uint64_t key = static_cast<std::uint64_t>(std::llround(cell * 1e5f));
  for (int axis = 0; axis < 3; ++axis) {
    key = key * 1000003 + static_cast<std::uint64_t>(std::llround(position[axis] / cell) + 100000);
  }
  for (int axis = 0; axis < 3; ++axis) {
    key = key * 1000003 + static_cast<std::uint64_t>(std::llround(normal[axis] * 4) + 10);
  }
  return key;
}

/// The R2 sequence (M. Roberts): evenly spread points of the unit square.
Vector2f SpreadPoint(int i) {
  const double u = 0.5 + 0.7548776662466927 * i, v = 0.5 + 0.5698402909980532 * i;
  return {static_cast<float>(u - std::floor(u)), static_cast<float>(v - std::floor(v))};
}

Vector2f DiskPoint(const Vector2f& square) {
  const float radius = std::sqrt(square.x()), angle = 2 * kPiF * square.y();
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
Vector3f DirectLight(const TracedScene& scene, const LightSources& sources, int rays,
                     const Vector3f& position, const Vector3f& normal) {
  const std::optional<SunLight>& sun = sources.sun;
  Vector3f sum = Vector3f::Zero();
  for (const AreaLight& light : sources.lights) {
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
    sum += light.radiance * (seen * area.norm() / (kPiF * static_cast<float>(rays)));
  }
  if (sun && normal.dot(sun->to_sun) > -sun->radius) {
    const Eigen::Matrix3f frame = FrameAround(sun->to_sun);
    const int sun_rays = 2 * rays;
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

/// Direction `i` about +z with density in proportion to the cosine; `shift` moves the whole set.
Vector3f CosineDirection(int i, const Vector2f& shift) {
  Vector2f square = SpreadPoint(i) + shift;
  square -= square.array().floor().matrix();
  const Vector2f disk = DiskPoint(square);
  return {disk.x(), disk.y(), std::sqrt(std::max(0.0f, 1 - disk.squaredNorm()))};
}

int Row(int steps, int j) { return j * (steps + 1) - j * (j - 1) / 2; }

}  // namespace

std::vector<LightMap::Point> LightMap::PlacePoints(const TracedScene& scene, float spacing) {
  std::vector<Point> points;
  std::unordered_map<std::uint64_t, std::uint32_t> known;
  const auto& vertices = scene.vertices();
  lattices_.reserve(scene.triangles().size());
  for (std::size_t t = 0; t < scene.triangles().size(); ++t) {
    const TracedScene::Triangle& triangle = scene.triangles()[t];
    const float spacing_m = spacing * triangle.light_spacing_m;
    std::array<Vector3f, 3> corner;
    for (int k = 0; k < 3; ++k) corner[k] = vertices[static_cast<std::size_t>(triangle.corners[k])];
    const float longest = std::max({(corner[1] - corner[0]).norm(), (corner[2] - corner[1]).norm(),
                                    (corner[0] - corner[2]).norm()});
    const int steps =
        triangle.lets_light_in
            ? 1
            : std::clamp(static_cast<int>(std::ceil(0.75f * longest / spacing_m)), 1, kMaxSteps);
    const Vector3f middle = (corner[0] + corner[1] + corner[2]) / 3;
    lattices_.push_back({static_cast<std::uint32_t>(indices_.size()), steps});
    for (int j = 0; j <= steps; ++j) {
      for (int i = 0; i + j <= steps; ++i) {
        const float u = static_cast<float>(i) / static_cast<float>(steps);
        const float v = static_cast<float>(j) / static_cast<float>(steps);
        const Vector3f position =
            corner[0] + u * (corner[1] - corner[0]) + v * (corner[2] - corner[0]);
        const Vector3f normal = scene.ShadingNormal({static_cast<std::uint32_t>(t), 0, u, v});
        const auto [entry, fresh] = known.try_emplace(CellKey(position, normal, spacing_m),
                                                      static_cast<std::uint32_t>(points.size()));
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

LightMap::Gathering LightMap::Gather(const TracedScene& scene, const std::optional<SkyLight>& sky,
                                     const Point& point, std::size_t index, int rays) const {
  const Eigen::Matrix3f frame = FrameAround(point.normal);
  const auto number = static_cast<int>(index);
  const Vector2f shift(CellNoise(number, 0, 0, 1), CellNoise(number, 1, 0, 1));
  Gathering result;
  int covered = 0;
  for (int i = 0; i < rays; ++i) {
    const Vector3f direction = frame * CosineDirection(i, shift);
    const TracedScene::Hit hit = scene.Trace(point.position, direction);
    if (!hit.valid()) {
      if (sky) result.light += sky->Radiance(direction);
      continue;
    }
    const TracedScene::Triangle& triangle = scene.triangles()[hit.triangle];
    const bool inside = scene.FaceNormal(hit.triangle).dot(direction) > 0;
    covered += inside || hit.distance < kCoveredM;
    if (triangle.lets_light_in) continue;  // counted as direct light
    const float emission = scene.material(triangle).emission;
    result.light += triangle.mean_color.cwiseProduct(At(hit) + Vector3f::Constant(emission));
  }
  result.light /= static_cast<float>(rays);
  result.covered = 2 * covered > rays;
  return result;
}

template <typename Share>
void LightMap::ForEachEdge(Share&& share) const {
  for (const Lattice& lattice : lattices_) {
    const auto at = [&](int i, int j) {
      return indices_[lattice.first + static_cast<std::uint32_t>(Row(lattice.steps, j) + i)];
    };
    for (int j = 0; j < lattice.steps; ++j) {
      for (int i = 0; i + j < lattice.steps; ++i) {
        share(at(i, j), at(i + 1, j));
        share(at(i, j), at(i, j + 1));
        share(at(i + 1, j), at(i, j + 1));
      }
    }
  }
}

void LightMap::Smooth(const std::vector<Point>& points, const std::vector<std::uint8_t>& covered,
                      std::vector<Vector3f>& values) const {
  for (int pass = 0; pass < kSmoothingPasses; ++pass) {
    std::vector<Vector3f> sums = values;
    std::vector<float> weights(values.size(), 1.0f);
    ForEachEdge([&](std::uint32_t a, std::uint32_t b) {
      if (a == b || covered[a] || covered[b] || points[a].normal.dot(points[b].normal) < 0.7f)
        return;
      constexpr float kWeight = 0.5f;  // an edge inside a face is met twice
      sums[a] += kWeight * values[b];
      sums[b] += kWeight * values[a];
      weights[a] += kWeight;
      weights[b] += kWeight;
    });
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = sums[i] / weights[i];
  }
}

void LightMap::FillCovered(std::vector<std::uint8_t> covered, std::vector<Vector3f>& values) const {
  for (int pass = 0; pass < kFillingPasses; ++pass) {
    std::vector<Vector3f> sums(values.size(), Vector3f::Zero());
    std::vector<int> counts(values.size(), 0);
    const auto give = [&](std::uint32_t from, std::uint32_t to) {
      if (covered[from] || !covered[to]) return;
      sums[to] += values[from];
      ++counts[to];
    };
    ForEachEdge([&](std::uint32_t a, std::uint32_t b) {
      give(a, b);
      give(b, a);
    });
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (counts[i] == 0) continue;
      values[i] = sums[i] / static_cast<float>(counts[i]);
      covered[i] = 0;
    }
  }
}

Result<LightMap> LightMap::Compute(const TracedScene& scene, const LightSources& sources,
                                   const LightQuality& quality, const WorkContext& context) {
  LightMap map;
  const std::vector<Point> points = map.PlacePoints(scene, static_cast<float>(quality.spacing));
  std::vector<Vector3f> direct(points.size()), light(points.size());
  std::vector<std::uint8_t> covered(points.size(), 0);
  map.light_.assign(points.size(), Vector3f::Zero());
  constexpr std::size_t kBatch = 8192;
  const int batches = static_cast<int>((points.size() + kBatch - 1) / kBatch);
  for (int bounce = 0; bounce < 3; ++bounce) {
    for (int batch = 0; batch < batches; ++batch) {
      if (context.stop.stop_requested()) {
        return Error{ErrorCode::kCancelled, "stopped while computing the light of the room"};
      }
      context.report({"light", bounce * batches + batch, 3 * batches});
      const std::size_t begin = static_cast<std::size_t>(batch) * kBatch;
      tbb::parallel_for(begin, std::min(begin + kBatch, points.size()), [&](std::size_t i) {
        if (bounce == 0) {
          light[i] =
              DirectLight(scene, sources, quality.rays, points[i].position, points[i].normal);
        } else {
          const Gathering gathering = map.Gather(scene, sources.sky, points[i], i, quality.rays);
          light[i] = gathering.light;
          covered[i] = gathering.covered;
        }
      });
    }
    if (bounce == 0) {
      direct = light;
    } else {
      map.Smooth(points, covered, light);
      for (std::size_t i = 0; i < light.size(); ++i) light[i] += direct[i];
      map.FillCovered(covered, light);
    }
    map.light_ = light;
  }
  context.report({"light", 3 * batches, 3 * batches});
  if (sources.sky) {
    map.FillCovered(covered, direct);
    map.direct_ = std::move(direct);
  }
  return map;
}

Vector3f LightMap::Interpolate(const std::vector<Vector3f>& values,
                               const TracedScene::Hit& hit) const {
  const Lattice& lattice = lattices_[hit.triangle];
  const int steps = lattice.steps;
  const float x = std::clamp(hit.u, 0.0f, 1.0f) * static_cast<float>(steps);
  const float y = std::clamp(hit.v, 0.0f, 1.0f) * static_cast<float>(steps);
  const int j = std::min(static_cast<int>(y), steps - 1);
  const int i = std::min(static_cast<int>(x), steps - 1 - j);
  const float dx = std::clamp(x - static_cast<float>(i), 0.0f, 1.0f);
  const float dy = std::clamp(y - static_cast<float>(j), 0.0f, 1.0f);
  const auto at = [&](int column, int row) {
    return values[indices_[lattice.first + static_cast<std::uint32_t>(Row(steps, row) + column)]];
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
