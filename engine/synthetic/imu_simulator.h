// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "engine/base/result.h"
#include "engine/dataset/reference_states.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"
#include "engine/synthetic/body_path.h"
#include "engine/synthetic/synthetic_options.h"
#include "engine/synthetic/walk.h"

namespace plumbline {

/// How the camera of synthetic sequences sits on the body: it looks along the body's x, as that of
/// a phone or a headset, some degrees and centimetres off.
Eigen::Isometry3d SyntheticBodyFromCam();

/// The walk as the body goes it: after the rest, with the tremor of hands.
/// @param seconds  Of the sequence.
BodyPath PathOfBody(const Walk& walk, const ImuSimulation& options, std::uint64_t seed,
                    double seconds);

/// What an IMU records along a path, and what it adds.
struct ImuTruth {
  ImuCalibration calibration;  ///< As imu.json states it: its offset is 0, whatever the true one.
  std::vector<ImuSample> samples;
  std::vector<ReferenceState> states;  ///< At the times of the images, on the camera's clock.
};

/// Readings from 0 s to half a second after the last image.
/// @param image_stamps_ns  Rising.
ImuTruth SimulateImu(const BodyPath& path, const Eigen::Isometry3d& world_from_room,
                     std::span<const std::int64_t> image_stamps_ns, const ImuSimulation& options,
                     std::uint64_t seed);

/// `camera` with the pose on the body that camera.json states: wrong by so much as is asked.
Camera StatedCamera(Camera camera, const ImuSimulation& options, std::uint64_t seed);

/// Writes imu.csv, imu.json and groundtruth.csv. Errors: kIo.
Status WriteImuFiles(const std::filesystem::path& folder, const ImuTruth& truth);

}  // namespace plumbline
