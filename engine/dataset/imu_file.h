// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/sensor/imu.h"

namespace plumbline {

/// What an IMU measured during a sequence.
struct ImuRecording {
  std::vector<ImuSample> samples;     ///< By strictly rising stamp.
  std::vector<std::string> warnings;  ///< What was odd, one sentence a kind.
};

/// Reads imu.csv: rows `t,wx,wy,wz,ax,ay,az` [s or ns, rad/s, m/s^2]. Rows that are incomplete or
/// not finite are left out with a warning; of rows with one stamp the first counts. Errors:
/// kNotFound, kIo, kCorrupt (no usable row), naming the file.
Result<ImuRecording> ReadImuFile(const std::filesystem::path& file);

}  // namespace plumbline
