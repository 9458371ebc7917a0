// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"
#include "engine/vio/imu_buffer.h"
#include "engine/vio/imu_integration.h"
#include "engine/vio/vio_options.h"

namespace plumbline {

/// A start that explains all images of a window at once.
struct RefinedStart {
  InertialState inertial;       ///< At the window's first image; heading and position as given.
  double velocity_std_m_s = 0;  ///< Of the least certain direction.
  int tracks = 0;               ///< That it explains.
};

/// The most probable attitude, velocity and biases at the first of the images, given all of them:
/// bundle adjustment over the points that were followed, on the one path that the IMU's readings
/// make of a start (docs/algorithms/vio.md, Start). Levenberg and Marquardt from `guess`; points
/// that do not fit are left out.
/// @param images  By rising stamp.
/// Nothing where too few points live long enough or none of it converges.
std::optional<RefinedStart> RefineStart(const Camera& camera, const ImuCalibration& imu,
                                        const ImuBuffer& readings,
                                        std::span<const TrackedImage> images,
                                        const InertialState& guess, const VioOptions& options);

}  // namespace plumbline
