// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/file_lock.h"

namespace plumbline {

/// Writes a sequence in Plumbline's own layout again, row by row as `plumbline record` does.
class ReplayedRecording {
 public:
  /// Copies all but images, color.csv and imu.csv, and claims the new folder.
  /// @param recorded  With imu.csv.
  ReplayedRecording(std::filesystem::path recorded, std::filesystem::path folder);

  /// Adds the next images, each once the readings up to its time plus `imu_ahead_ms` are there.
  /// @return false once there are no more; the rest of the readings is then there, too.
  bool Add(int images, double imu_ahead_ms = 60);
  /// The writer is gone.
  void End() { lock_.reset(); }

 private:
  std::filesystem::path recorded_, folder_;
  std::unique_ptr<FileLock> lock_;
  std::vector<std::string> image_rows_, imu_rows_;
  std::size_t next_image_ = 0, next_imu_ = 0;
};

}  // namespace plumbline
