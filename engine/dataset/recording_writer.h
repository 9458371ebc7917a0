// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/result.h"
#include "engine/sensor/imu.h"

namespace plumbline {

/// Writes a sequence in Plumbline's own layout while it is recorded, so that FollowRecording can
/// map it meanwhile: an image is whole before its row is there, rows are appended whole, and
/// color.csv is locked for as long as this lives. What was added survives however the process ends.
/// Images and readings may be added by two threads.
class RecordingWriter {
 public:
  /// @param camera, imu  camera.json (with `rate_hz`) and imu.json. @param folder  New, or empty.
  /// Errors: kInvalidInput (not empty, or somebody records into it), kIo.
  static Result<std::unique_ptr<RecordingWriter>> Create(const std::filesystem::path& folder,
                                                         const nlohmann::json& camera,
                                                         const std::optional<nlohmann::json>& imu);
  /// Goes on with a recording that this made, while somebody else holds color.csv locked: a camera
  /// and an IMU may be recorded by processes of their own, and one that died is started again. Each
  /// adds its own kind only. Errors: kNotFound, kIo.
  static Result<std::unique_ptr<RecordingWriter>> Join(const std::filesystem::path& folder);
  /// Removes a recording to which nothing came; what is not of it stays.
  static void RemoveIfEmpty(const std::filesystem::path& folder);
  ~RecordingWriter();
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// By rising stamp, all on one clock with the images but for `time_offset_s`. Errors: kIo.
  Status AddReadings(std::span<const ImuSample> samples);
  /// @param encoded  A file with this ending, as ".jpg". Errors: kIo.
  Status AddImage(std::int64_t stamp_ns, std::string_view encoded, std::string_view ending);

  int num_images() const { return num_images_; }
  /// Whether another had added readings before this joined.
  bool joined_readings() const { return joined_readings_; }
  /// Gives the lock away, which whoever keeps it holds the recording open by.
  std::unique_ptr<FileLock> TakeLock() { return std::move(lock_); }

 private:
  RecordingWriter(std::filesystem::path folder, std::unique_ptr<FileLock> lock)
      : folder_(std::move(folder)), lock_(std::move(lock)) {}
  Status OpenTables();
  Status Append(int descriptor, const char* name, std::string_view rows) const;

  std::filesystem::path folder_;
  std::unique_ptr<FileLock> lock_;
  int images_ = -1, readings_ = -1;  ///< color.csv and imu.csv.
  std::atomic<int> num_images_ = 0;
  bool joined_readings_ = false;
};

}  // namespace plumbline
