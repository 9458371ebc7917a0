// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/result.h"
#include "engine/dataset/recording_writer.h"
#include "engine/sensor/camera.h"
#include "engine/sources/camera_input.h"
#include "engine/sources/imu_input.h"

namespace plumbline {

/// Writes what a camera gives into a recording. Of one thread; its counts may be read by others.
class CameraRecorder {
 public:
  /// @param lossless  PNG instead of JPEG.
  CameraRecorder(const Camera& camera, bool lossless, RecordingWriter& writer)
      : camera_(camera), lossless_(lossless), writer_(writer) {}

  /// Until the work is stopped or nothing more can come. Errors: those of ReadCamera and of the
  /// writer; kInvalidInput where the images are of another size than the camera's.
  Status Run(const CameraInput& input, const SensorWork& work);

  int images() const { return images_; }
  int gaps() const { return gaps_; }  ///< Steps in which images are missing.

 private:
  Status Take(const cv::Mat& picture, std::int64_t stamp_ns, const SensorWork& work);

  const Camera camera_;
  const bool lossless_;
  RecordingWriter& writer_;
  std::vector<unsigned char> encoded_;
  std::int64_t last_ns_ = 0;
  std::atomic<int> images_ = 0, gaps_ = 0;
};

/// Writes what an IMU gives into a recording, carried over to this machine's clock. As above.
class ImuRecorder {
 public:
  /// @param clock_file  Keeps how far the clocks are apart, so that another that goes on with the
  /// recording carries readings over by the same; empty: none will.
  explicit ImuRecorder(RecordingWriter& writer, std::filesystem::path clock_file = {});

  /// Errors: those of ReadImuInput and of the writer.
  Status Run(const std::string& spec, const SensorWork& work);

  int readings() const { return readings_; }
  int not_understood() const { return not_understood_; }  ///< Lines.
  int not_later() const { return not_later_; }            ///< Than the reading before.
  std::int64_t offset_ns() const { return offset_ns_; }   ///< What a stamp of the IMU is added to.

 private:
  Status Take(const std::optional<ImuLine>& line, std::int64_t arrived_ns, const SensorWork& work);
  Status AddHeld(const SensorWork& work);
  Status Add(const ImuLine& reading, std::int64_t arrived_ns, const SensorWork& work);

  RecordingWriter& writer_;
  const std::filesystem::path clock_file_;
  ClockCarrier carrier_;
  bool carried_ = false;                                ///< By whoever sends.
  std::vector<std::pair<ImuLine, std::int64_t>> held_;  ///< Until the clocks are known.
  std::int64_t last_ns_ = std::numeric_limits<std::int64_t>::min();
  std::atomic<int> readings_ = 0, not_understood_ = 0, not_later_ = 0;
  std::atomic<std::int64_t> offset_ns_ = 0;
};

}  // namespace plumbline
