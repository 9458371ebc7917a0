// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/track_simulator.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/geometry/surface_sampling.h"

namespace plumbline {
namespace {

constexpr double kBorder = 4;         ///< Of the image, where nothing is followed [px].
constexpr double kSurface = 0.01;     ///< What is hit so near to a point is its own surface [m].
constexpr double kMinDistance = 0.2;  ///< [m]

}  // namespace

TrackSimulator::TrackSimulator(const TracedScene& scene, const PinholeCamera& camera,
                               const Options& options, std::uint64_t seed)
    : scene_(scene),
      camera_(camera),
      options_(options),
      random_({.seed = seed, .object = 0x54524b}) {
  TriangleMesh mesh;
  mesh.vertices = scene.vertices();
  for (const TracedScene::Triangle& triangle : scene.triangles()) {
    if (!triangle.lets_light_in) mesh.triangles.push_back(triangle.corners);
  }
  const int count = static_cast<int>(options.points_per_m2 * SurfaceArea(mesh));
  Result<SurfaceSamples> samples = SampleSurface(mesh, count, seed);
  PLB_CHECK(samples.ok());  // a room has walls
  points_ = std::move(samples->points);
  for (std::size_t i = points_.size(); i > 1; --i)
    std::swap(points_[i - 1], points_[random_.Index(static_cast<std::uint32_t>(i))]);
}

std::optional<Eigen::Vector2d> TrackSimulator::See(const Shutter& shutter,
                                                   const Eigen::Vector3d& point) const {
  const Eigen::Isometry3d room_from_cam = shutter.Seeing(point);
  const Eigen::Vector3d in_cam = room_from_cam.inverse() * point;
  const double distance = in_cam.norm();
  if (in_cam.z() < kMinDistance || distance > options_.max_distance_m) return std::nullopt;
  const Eigen::Vector2d pixel = camera_.Project(in_cam);
  if (pixel.x() < kBorder || pixel.y() < kBorder || pixel.x() > camera_.width - 1 - kBorder ||
      pixel.y() > camera_.height - 1 - kBorder)
    return std::nullopt;
  const Eigen::Vector3f eye = room_from_cam.translation().cast<float>();
  const Eigen::Vector3f direction =
      ((point - room_from_cam.translation()) / distance).cast<float>();
  const TracedScene::Hit hit = scene_.Trace(eye, direction);
  if (hit.valid() && hit.distance < distance - kSurface) return std::nullopt;
  return pixel;
}

TrackedImage TrackSimulator::Next(std::int64_t stamp_ns, const Shutter& shutter) {
  std::map<std::size_t, Eigen::Vector2d> seen;
  for (auto entry = followed_.begin(); entry != followed_.end();) {
    const auto pixel = See(shutter, points_[entry->first]);
    const bool broken = random_.Uniform() < options_.break_probability;
    if (pixel && !broken) {
      seen[entry->first] = *pixel;
      ++entry;
    } else {
      entry = followed_.erase(entry);
    }
  }
  for (std::size_t tried = 0;
       tried < points_.size() && static_cast<int>(followed_.size()) < options_.points; ++tried) {
    cursor_ = (cursor_ + 1) % points_.size();
    if (followed_.count(cursor_) > 0) continue;
    const auto pixel = See(shutter, points_[cursor_]);
    if (!pixel) continue;
    followed_[cursor_] = next_track_++;
    seen[cursor_] = *pixel;
  }
  TrackedImage image;
  image.stamp_ns = stamp_ns;
  for (const auto& [point, pixel] : seen) {
    const double u = random_.Gaussian(), v = random_.Gaussian();
    image.points.push_back(
        {followed_.at(point), pixel + options_.noise_px * Eigen::Vector2d(u, v)});
  }
  return image;
}

}  // namespace plumbline
