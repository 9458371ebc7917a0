// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/synthetic/room.h"
#include "engine/synthetic/traced_scene.h"

namespace plumbline {

/// The light that falls on every surface of a still room, computed once: direct light with soft
/// shadows and two diffuse bounces, at a barycentric lattice of points on every triangle (mesh
/// colours: Yuksel, Keyser and House, ACM Trans. Graphics 29(2), 2010). Every point looks in the
/// same directions, so that what is left of the sampling error varies as smoothly as the light
/// itself. Pictures then show no grain and nothing flickers.
class LightMap {
 public:
  /// @param rays  Rays per point and bounce; points on the lights in proportion.
  /// Errors: kCancelled.
  static Result<LightMap> Compute(const TracedScene& scene, std::span<const AreaLight> lights,
                                  const std::optional<SunLight>& sun, int rays,
                                  const WorkContext& context);

  /// Irradiance divided by pi at a point of the scene it was computed for.
  Eigen::Vector3f At(const TracedScene::Hit& hit) const;
  std::size_t size() const { return light_.size(); }
  /// Mean over all points, for the exposure of the camera.
  float MeanLuminance() const;

 private:
  struct Point {
    Eigen::Vector3f position, normal;
  };
  struct Lattice {
    std::uint32_t first = 0;
    int steps = 1;
  };
  std::vector<Point> PlacePoints(const TracedScene& scene);

  std::vector<Lattice> lattices_;       ///< One for each triangle.
  std::vector<std::uint32_t> indices_;  ///< Of lattice points into light_; neighbours share.
  std::vector<Eigen::Vector3f> light_;
};

}  // namespace plumbline
