// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include <Eigen/Core>

#include "engine/dataset/tracks_file.h"
#include "engine/sensor/distorted_camera.h"

namespace plumbline {

/// A track as seen from one clone.
struct Observation {
  std::int64_t clone = 0;
  Eigen::Vector2d pixel;
  Eigen::Vector3d ray;  ///< Unit, in the camera.
};

/// What is not yet used of a track that is not in the state.
struct Track {
  std::vector<Observation> observations;  ///< By rising clone.
  int age = 0;                            ///< Images that it was seen in, used or not.
  bool seen = false;                      ///< In the newest image.
};

/// The tracks that the filter follows, by their numbers.
class TrackTable {
 public:
  /// @param max_tracks  New tracks are begun up to this many, spread over the image.
  TrackTable(const Camera& camera, int max_tracks);

  /// Files the points of an image under a clone. Those that the lens model cannot see are left
  /// out. @param kept  Tracks of points in the state: not filed, but counted.
  void Add(const TrackedImage& image, std::int64_t clone, const std::map<std::int64_t, int>& kept);
  /// Forgets what was seen from a clone.
  void ForgetClone(std::int64_t clone);
  /// New sights are unprojected with this camera.
  void SetCamera(const DistortedCamera& camera) { camera_ = camera; }
  void Erase(std::int64_t track) { tracks_.erase(track); }
  void Clear() { tracks_.clear(); }

  std::map<std::int64_t, Track>& tracks() { return tracks_; }

 private:
  void AddPoint(const TrackedPoint& point, std::int64_t clone);

  DistortedCamera camera_;
  int width_, height_;
  int max_tracks_;
  std::map<std::int64_t, Track> tracks_;
};

}  // namespace plumbline
