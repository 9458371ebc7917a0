// SPDX-License-Identifier: Apache-2.0
#include "engine/sources/sensor_recorder.h"

#include <cstdio>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "engine/base/files.h"

namespace plumbline {
namespace {

constexpr int kJpegQuality = 95;
constexpr int kReadingsForClock = 100;
constexpr double kGapPeriods = 1.5;  ///< Of a camera: longer, images are missing.
constexpr const char* kOffset = "imu_later_ns";

}  // namespace

Status CameraRecorder::Run(const CameraInput& input, const SensorWork& work) {
  return ReadCamera(input, camera_, work, [&](const cv::Mat& picture, std::int64_t stamp_ns) {
    return Take(picture, stamp_ns, work);
  });
}

Status CameraRecorder::Take(const cv::Mat& picture, std::int64_t stamp_ns, const SensorWork& work) {
  const PinholeCamera& size = camera_.pinhole;
  if (picture.cols != size.width || picture.rows != size.height) {
    return Error{ErrorCode::kInvalidInput,
                 "the camera gives images of " + std::to_string(picture.cols) + "x" +
                     std::to_string(picture.rows) + ", its calibration is of " +
                     std::to_string(size.width) + "x" + std::to_string(size.height)};
  }
  if (images_ > 0 && stamp_ns <= last_ns_) return {};
  const double step_s = 1e-9 * static_cast<double>(stamp_ns - last_ns_);
  if (images_ > 0 && step_s * camera_.rate_hz > kGapPeriods) ++gaps_;
  last_ns_ = stamp_ns;
  const char* ending = lossless_ ? ".png" : ".jpg";
  cv::imencode(ending, picture, encoded_, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality});
  ++images_;
  work.came();
  return writer_.AddImage(
      stamp_ns, {reinterpret_cast<const char*>(encoded_.data()), encoded_.size()}, ending);
}

ImuRecorder::ImuRecorder(RecordingWriter& writer, std::filesystem::path clock_file)
    : writer_(writer), clock_file_(std::move(clock_file)), carrier_(kReadingsForClock) {
  std::error_code ignored;
  if (clock_file_.empty() || !std::filesystem::exists(clock_file_, ignored)) return;
  const Result<nlohmann::json> kept = ReadJson(clock_file_);
  if (!kept.ok() || !kept->contains(kOffset) || !(*kept)[kOffset].is_number_integer()) return;
  carrier_.Know((*kept)[kOffset].get<std::int64_t>());
  offset_ns_ = carrier_.offset_ns();
}

Status ImuRecorder::Run(const std::string& spec, const SensorWork& work) {
  carried_ = IsPlayed(spec);
  Status status =
      ReadImuInput(spec, work, [&](const std::optional<ImuLine>& line, std::int64_t arrived_ns) {
        return Take(line, arrived_ns, work);
      });
  const Status held = AddHeld(work);  // of an IMU that gave few readings
  return status.ok() ? held : status;
}

Status ImuRecorder::Take(const std::optional<ImuLine>& line, std::int64_t arrived_ns,
                         const SensorWork& work) {
  if (!line) {
    ++not_understood_;
    return {};
  }
  if (carried_ || !line->stamp_ns) return Add(*line, arrived_ns, work);
  if (const double jump_s = carrier_.JumpBefore(*line->stamp_ns, arrived_ns); jump_s != 0) {
    char sentence[120];
    std::snprintf(sentence, sizeof(sentence),
                  "the clock of the IMU has jumped by %+.1f s; it is carried over anew", jump_s);
    work.tell(sentence);
    if (Status status = AddHeld(work); !status.ok()) return status;
    carrier_ = ClockCarrier(kReadingsForClock);
  }
  const bool was_ready = carrier_.ready();
  carrier_.See(*line->stamp_ns, arrived_ns);
  if (was_ready) return Add(*line, arrived_ns, work);
  held_.emplace_back(*line, arrived_ns);
  return carrier_.ready() ? AddHeld(work) : Status();
}

Status ImuRecorder::AddHeld(const SensorWork& work) {
  if (held_.empty()) return {};
  offset_ns_ = carrier_.offset_ns();
  if (!clock_file_.empty() && carrier_.ready()) {
    if (Status status = WriteJson(clock_file_, {{kOffset, carrier_.offset_ns()}}); !status.ok())
      return status;
  }
  for (const auto& [reading, arrived_ns] : std::exchange(held_, {}))
    if (Status status = Add(reading, arrived_ns, work); !status.ok()) return status;
  return {};
}

Status ImuRecorder::Add(const ImuLine& reading, std::int64_t arrived_ns, const SensorWork& work) {
  const std::int64_t offset_ns = carried_ ? 0 : carrier_.offset_ns();
  const ImuSample sample{reading.stamp_ns ? *reading.stamp_ns + offset_ns : arrived_ns,
                         reading.angular_velocity_rad_s, reading.specific_force_m_s2};
  if (sample.stamp_ns <= last_ns_) {
    ++not_later_;
    return {};
  }
  last_ns_ = sample.stamp_ns;
  ++readings_;
  work.came();
  return writer_.AddReadings({&sample, 1});
}

}  // namespace plumbline
