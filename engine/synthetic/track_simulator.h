// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "engine/base/random.h"
#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/synthetic/shutter.h"
#include "engine/synthetic/traced_scene.h"

namespace plumbline {

/// Follows points on the surfaces of a room without drawing it: what hides what is traced, noise is
/// added, and tracks break now and then.
class TrackSimulator {
 public:
  struct Options {
    int points = 120;  ///< Followed at a time.
    double noise_px = 1;
    double points_per_m2 = 12;
    double max_distance_m = 15;
    double break_probability = 0.01;  ///< Of a track, in each image.
  };

  TrackSimulator(const TracedScene& scene, const PinholeCamera& camera, const Options& options,
                 std::uint64_t seed);

  TrackedImage Next(std::int64_t stamp_ns, const Shutter& shutter);

 private:
  std::optional<Eigen::Vector2d> See(const Shutter& shutter, const Eigen::Vector3d& point) const;

  const TracedScene& scene_;
  PinholeCamera camera_;
  Options options_;
  std::vector<Eigen::Vector3d> points_;  ///< In random order.
  Random random_;
  std::map<std::size_t, std::int64_t> followed_;  ///< Number of a point's track.
  std::size_t cursor_ = 0;                        ///< Where new points are sought from.
  std::int64_t next_track_ = 0;
};

}  // namespace plumbline
