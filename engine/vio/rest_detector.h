// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <deque>
#include <optional>

#include "engine/dataset/tracks_file.h"

namespace plumbline {

/// Tells from the motion of tracked points whether the camera rests. An IMU alone cannot: it does
/// not feel a steady motion, and it feels a desk that shakes.
class RestDetector {
 public:
  /// @param memory_s  How far back images are kept.
  explicit RestDetector(double memory_s) : memory_ns_(static_cast<std::int64_t>(memory_s * 1e9)) {}

  void Add(const TrackedImage& image);
  void Clear() { images_.clear(); }

  /// How far [px] the points of the newest image have wandered during the last `seconds`: the
  /// median distance between where each was on average in the first and in the second half of that
  /// time, less what the points' jumps from image to image explain of it. What only shakes about
  /// its place rests. Nothing where images do not reach that far back
  /// or too few points live as long.
  std::optional<double> WanderWithin(double seconds) const;

 private:
  std::int64_t memory_ns_;
  std::deque<TrackedImage> images_;
};

}  // namespace plumbline
