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

struct LightQuality {
  int rays = 72;  ///< Per point and bounce; points on the lights in proportion.
  double spacing =
      1.0;  ///< Factor on the distances between points that the parts of the room ask for.
};

/// Where light comes from.
struct LightSources {
  std::span<const AreaLight> lights;
  std::optional<SunLight> sun;
  std::optional<SkyLight> sky;
};

/// The light that falls on every surface of a still room, computed once: direct light with soft
/// shadows and two diffuse bounces, at a barycentric lattice of points on every triangle (mesh
/// colours: Yuksel, Keyser and House, ACM Trans. Graphics 29(2), 2010). Direct light looks at the
/// same places on the lights from every point, so that its error is as smooth as the light itself;
/// bounced light is averaged over neighbours. Pictures then show no grain and nothing flickers.
class LightMap {
 public:
  /// Errors: kCancelled.
  static Result<LightMap> Compute(const TracedScene& scene, const LightSources& sources,
                                  const LightQuality& quality, const WorkContext& context);

  /// Irradiance divided by pi at a point of the scene it was computed for.
  Eigen::Vector3f At(const TracedScene::Hit& hit) const { return Interpolate(light_, hit); }
  /// Of it, what comes straight from the lights and the sun, where there is a sky besides.
  Eigen::Vector3f DirectAt(const TracedScene::Hit& hit) const { return Interpolate(direct_, hit); }
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
  std::vector<Point> PlacePoints(const TracedScene& scene, float spacing);
  struct Gathering {
    Eigen::Vector3f light{0, 0, 0};
    bool covered = false;  ///< Something lies on the point.
  };
  /// Mean light that arrives from `rays` directions; each point turns them differently.
  Gathering Gather(const TracedScene& scene, const std::optional<SkyLight>& sky, const Point& point,
                   std::size_t index, int rays) const;
  Eigen::Vector3f Interpolate(const std::vector<Eigen::Vector3f>& values,
                              const TracedScene::Hit& hit) const;
  /// Calls `share(a, b)` for the two points of every lattice edge; inner edges come twice.
  template <typename Share>
  void ForEachEdge(Share&& share) const;
  /// Averages values with their neighbours on the surface.
  void Smooth(const std::vector<Point>& points, const std::vector<std::uint8_t>& covered,
              std::vector<Eigen::Vector3f>& values) const;
  /// Gives covered points the light of their neighbours.
  void FillCovered(std::vector<std::uint8_t> covered, std::vector<Eigen::Vector3f>& values) const;

  std::vector<Lattice> lattices_;       ///< One for each triangle.
  std::vector<std::uint32_t> indices_;  ///< Of lattice points into light_; neighbours share.
  std::vector<Eigen::Vector3f> light_, direct_;
};

}  // namespace plumbline
