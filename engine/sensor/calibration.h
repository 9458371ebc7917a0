// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/sensor/camera.h"
#include "engine/sensor/imu.h"

namespace plumbline {

/// A camera of a rig; its `body_from_cam` says where it sits.
struct NamedCamera {
  std::string name;
  Camera camera;
};

/// The sensors that recorded something. Packets name a camera by its index here; poses are those of
/// the first one.
struct Calibration {
  std::vector<NamedCamera> cameras;  ///< At least one.
  std::optional<ImuCalibration> imu;
};

}  // namespace plumbline
