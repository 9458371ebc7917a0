// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/vio/imu_buffer.h"

namespace plumbline {

/// An offset of the clocks (IMU time = image time + offset) and how badly it fits.
struct ClockFit {
  double offset_s = 0;
  double residual_px = 0;        ///< Rms distance of points from their epipolar lines.
  double given_residual_px = 0;  ///< The same for the offset that was given.
};

/// Seeks the offset with which the gyro's turn between images leaves only a translation: with the
/// right one, the planes of a point's two rays share one line. It needs no depth, no velocity and
/// no gravity, and some turning.
/// @param images     By rising stamp, about a second of them.
/// @param given_s    Where the search begins; it reaches as far as the readings do, at most
///                   `reach_s` to both sides.
/// @return nothing where readings or common points are too few for the given offset.
std::optional<ClockFit> SearchClock(const Camera& camera, const ImuBuffer& readings,
                                    const Eigen::Vector3d& gyro_bias,
                                    std::span<const TrackedImage> images, double given_s,
                                    double reach_s);

}  // namespace plumbline
