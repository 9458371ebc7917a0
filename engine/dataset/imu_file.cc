// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/imu_file.h"

#include <utility>

#include "engine/dataset/stamped_rows.h"

namespace plumbline {

Result<ImuRecording> ReadImuFile(const std::filesystem::path& file) {
  ImuRecording recording;
  auto warnings = ReadStampedRows(
      file, {"t,wx,wy,wz,ax,ay,az", 6}, [&](std::int64_t stamp_ns, std::span<const double> v) {
        recording.samples.push_back({stamp_ns, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
      });
  if (!warnings.ok()) return warnings.error();
  recording.warnings = std::move(warnings).value();
  if (recording.samples.empty()) {
    return Error{ErrorCode::kCorrupt, "'" + file.string() +
                                          "' holds no usable IMU sample; it needs rows "
                                          "'t,wx,wy,wz,ax,ay,az' in rad/s and m/s^2"};
  }
  MakeStampsRise(file, "IMU samples", recording.samples, recording.warnings);
  return recording;
}

}  // namespace plumbline
