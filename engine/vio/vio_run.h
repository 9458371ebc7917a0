// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/dataset/reference_states.h"
#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"
#include "engine/vio/vio_estimator.h"
#include "engine/vio/vio_options.h"
#include "engine/vio/vio_report.h"

namespace plumbline {

/// What a whole recording gave.
struct VioRun {
  std::vector<VioReport> reports;  ///< One for each image that was used.
  std::vector<MapPoint> points;
};

/// A recording: both by rising stamp.
struct VioInput {
  Camera camera;
  ImuCalibration imu;
  std::span<const ImuSample> samples;
  std::span<const TrackedImage> images;
  std::optional<ReferenceState> start;  ///< Nothing: the estimator finds its own.
};

/// Runs the estimator over a recording in the order of time.
VioRun RunVio(const VioInput& input, const VioOptions& options);

/// Leaves out tracks at random: each with this probability, for all its life.
std::vector<TrackedImage> DropTracks(std::span<const TrackedImage> images, double probability,
                                     std::uint64_t seed);

}  // namespace plumbline
