// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/recording_rig.h"

#include <utility>

#include "engine/base/files.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

Result<RecordingRig> ReadRecordingRig(const std::filesystem::path& place) {
  std::filesystem::path file = place;
  std::error_code ignored;
  RecordingRig rig;
  if (std::filesystem::is_directory(file, ignored)) {
    if (const auto imu = file / "imu.json"; std::filesystem::exists(imu, ignored)) {
      auto read = ReadJson(imu);
      if (!read.ok()) return read.error();
      rig.imu_json = std::move(read).value();
    }
    file /= "camera.json";
  }
  auto json = ReadJson(file);
  if (!json.ok()) return json.error();
  rig.camera_json = std::move(json).value();
  Result<Camera> camera = CameraFromJson(rig.camera_json, file);
  if (!camera.ok()) return camera.error();
  rig.camera = std::move(camera).value();
  return rig;
}

std::string NoBodyFromCam(const std::filesystem::path& place) {
  return "'" + place.string() +
         "' does not say where the camera sits on the IMU (body_from_cam): no poses can be found "
         "from this recording";
}

}  // namespace plumbline
