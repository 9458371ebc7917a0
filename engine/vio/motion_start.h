// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <Eigen/Core>

#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"
#include "engine/vio/imu_buffer.h"

namespace plumbline {

/// What a short window in motion says of its first image.
struct MotionStart {
  Eigen::Vector3d gravity_in_body{0, 0, 0};   ///< At the first image [m/s^2].
  Eigen::Vector3d velocity_in_body{0, 0, 0};  ///< At the first image, along the body's axes [m/s].
  Eigen::Vector3d gyro_bias{0, 0, 0};         ///< [rad/s]
  double residual_px = 0;                     ///< Median over the tracks of their rms.
  int tracks = 0;
};

/// Visual-inertial alignment: the gyro turns the window's images into one frame; there the rays of
/// the tracks, the twice integrated accelerometer, the velocity and gravity meet in linear
/// equations, once the depth of each track is eliminated (Dong-Si and Mourikis, IROS 2012). The
/// gyro's bias is found around them by Gauss-Newton, gravity has its length, and mismatches are
/// left out. The accelerometer's bias is taken as zero: in so short a time it cannot be told from
/// gravity.
/// @param images  By rising stamp, about a second.
/// Errors: kDegenerate, with what is missing.
Result<MotionStart> AlignInMotion(const Camera& camera, const ImuCalibration& imu,
                                  const ImuBuffer& readings, std::span<const TrackedImage> images);

}  // namespace plumbline
