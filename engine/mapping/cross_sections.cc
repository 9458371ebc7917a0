// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/cross_sections.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace plumbline {
namespace {

constexpr float kSpacing_m = 0.02F;  ///< Of levels.
constexpr int kPoints = 16;          ///< Of a level.

using Segment = std::pair<Eigen::Vector2f, Eigen::Vector2f>;

float Length(const Segment& segment) { return (segment.second - segment.first).norm(); }

std::vector<Eigen::Vector2f> EvenlyAlong(const std::vector<Segment>& segments) {
  float total_m = 0;
  for (const Segment& segment : segments) total_m += Length(segment);
  std::vector<Eigen::Vector2f> points;
  if (total_m <= 0) return points;
  const float step_m = total_m / kPoints;
  float next_m = 0.5F * step_m, passed_m = 0;
  for (const Segment& segment : segments) {
    const float length_m = Length(segment);
    for (; next_m < passed_m + length_m && points.size() < kPoints; next_m += step_m)
      points.push_back(segment.first +
                       (next_m - passed_m) / length_m * (segment.second - segment.first));
    passed_m += length_m;
  }
  return points;
}

}  // namespace

CrossSections::CrossSections(const CadModel& model) {
  const float bottom_m = model.bounds.min().z();
  const auto level_height = [&](std::size_t level) {
    return bottom_m + (static_cast<float>(level) + 0.5F) * kSpacing_m;
  };
  std::vector<std::vector<Segment>> cuts(
      static_cast<std::size_t>(model.bounds.sizes().z() / kSpacing_m) + 1);
  for (const auto& triangle : model.mesh.triangles) {
    float low_m = model.bounds.max().z(), high_m = bottom_m;
    for (const auto index : triangle) {
      low_m = std::min(low_m, model.mesh.vertices[index].z());
      high_m = std::max(high_m, model.mesh.vertices[index].z());
    }
    for (auto level = static_cast<std::size_t>((low_m - bottom_m) / kSpacing_m);
         level < cuts.size() && level_height(level) < high_m; ++level) {
      const float height_m = level_height(level);
      std::vector<Eigen::Vector2f> ends;
      for (std::size_t k = 0; k < 3; ++k) {
        const Eigen::Vector3f& from = model.mesh.vertices[triangle[k]];
        const Eigen::Vector3f& to = model.mesh.vertices[triangle[(k + 1) % 3]];
        if ((from.z() < height_m) == (to.z() < height_m)) continue;
        const float share = (height_m - from.z()) / (to.z() - from.z());
        ends.push_back(from.head<2>() + share * (to - from).head<2>());
      }
      if (ends.size() == 2) cuts[level].emplace_back(ends[0], ends[1]);
    }
  }
  for (const std::vector<Segment>& segments : cuts) levels_.push_back(EvenlyAlong(segments));
}

std::span<const Eigen::Vector2f> CrossSections::At(double height_m) const {
  if (height_m < 0 || height_m >= kSpacing_m * static_cast<double>(levels_.size())) return {};
  return levels_[static_cast<std::size_t>(height_m / kSpacing_m)];
}

}  // namespace plumbline
