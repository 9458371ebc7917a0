// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/dataset/reference_states.h"
#include "engine/dataset/tracks_file.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"

namespace plumbline {

struct VioSimulation {
  double seconds = 20;
  double rest_s = 0;  ///< Without any motion, at the start.
  bool moves = true;  ///< Otherwise it only turns, in place.
  double arm = 1;     ///< Times (0.05, -0.03, 0.02) m, the camera on the body.
  int points = 60;    ///< Followed at a time.
  /// In the room; where all that are in sight are followed, they are known by one number for ever.
  int room_points = 1500;
  bool follow_all = false;
  double image_hz = 20, imu_hz = 200;
  double pixel_noise_px = 1;
  double imu_noise = 1;  ///< Times the densities of ImuCalibration().
  /// Of the points that are followed, slides over the picture from this time on, all alike.
  double sliding_share = 0, sliding_from_s = 0, sliding_px = 4;
  double time_offset_s = 0;  ///< Added to an image's time to get the IMU's.
  double rolling_shutter_s = 0;
  Eigen::Vector3d gyro_bias{0.01, -0.02, 0.015};
  Eigen::Vector3d accel_bias{0.05, -0.03, 0.04};
  std::uint64_t seed = 1;
};

/// What a body that swings about in a room of 8 x 8 x 4 m records, and the truth. It is back where
/// it was, and looks the same way, after each 20 pi seconds of motion.
struct SimulatedRecording {
  Camera camera;  ///< True, read-out included; radial-tangential, 640x480.
  ImuCalibration imu;
  std::vector<ImuSample> samples;
  std::vector<TrackedImage> images;
  std::vector<ReferenceState> truth;  ///< One for each image, at its time on the camera's clock.
};

SimulatedRecording Simulate(const VioSimulation& options);

}  // namespace plumbline
