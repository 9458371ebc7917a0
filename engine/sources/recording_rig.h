// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "engine/base/result.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// What is known of a camera and an IMU before they record: goes into the recording as it is.
struct RecordingRig {
  nlohmann::json camera_json;
  std::optional<nlohmann::json> imu_json;
  Camera camera;
};

/// @param place  camera.json, or a folder with it and imu.json. Errors: kNotFound, kCorrupt,
/// kInvalidInput.
Result<RecordingRig> ReadRecordingRig(const std::filesystem::path& place);

/// For a camera.json that does not say where the camera sits on the IMU.
std::string NoBodyFromCam(const std::filesystem::path& place);

}  // namespace plumbline
