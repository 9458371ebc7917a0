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

  /// Median distance [px] between where points are in the newest image and where they were
  /// `seconds` before, or in the nearest image before that. Nothing where there is no image that
  /// old, or too few points in common.
  std::optional<double> MotionSince(double seconds) const;

  /// The largest of MotionSince over all images of the last `seconds`: the camera rested all that
  /// time. Nothing where there is not as much.
  std::optional<double> MostMotionWithin(double seconds) const;

 private:
  std::int64_t memory_ns_;
  std::deque<TrackedImage> images_;
};

}  // namespace plumbline
