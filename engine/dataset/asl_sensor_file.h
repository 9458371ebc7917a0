// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/base/result.h"
#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"

namespace plumbline {

/// The camera that a sensor.yaml of the ASL layout describes. Errors: kNotFound, kCorrupt,
/// kInvalidInput, kUnsupported (another model than pinhole), naming the file.
Result<Camera> ReadAslCamera(const std::filesystem::path& file);

/// The IMU that a sensor.yaml of the ASL layout describes; what it does not say is that of
/// ImuCalibration. Errors: kNotFound, kCorrupt, naming the file.
Result<ImuCalibration> ReadAslImu(const std::filesystem::path& file);

}  // namespace plumbline
