// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <string>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/sensor/camera.h"
#include "engine/sources/imu_lines.h"

namespace plumbline {

/// This machine's steady clock [ns], which recordings are stamped by.
std::int64_t SteadyNs();

/// What comes from a camera or an IMU is handed over as it comes, in the caller's thread, until
/// `stop` is requested or nothing more can come.
struct RecordWork {
  std::int64_t began_ns = 0;  ///< When the first image of what is played again comes.
  std::stop_token stop;
  /// Something went wrong that may pass, in one sentence.
  std::function<void(const std::string& sentence)> tell;
};

/// @param spec  A number or /dev/videoN (V4L2), play:SEQUENCE, or what OpenCV opens: a video file,
/// a URL. @param camera  What is asked of a V4L2 camera: size and rate.
/// @param image  CV_8UC3 BGR, and when it was taken. Errors: kNotFound, kIo; those of the sequence;
/// what `image` returns.
Status ReadCamera(
    const std::string& spec, const Camera& camera, const RecordWork& work,
    const std::function<Status(const cv::Mat& picture, std::int64_t stamp_ns)>& image);

/// @param spec  serial:DEVICE[@BAUD], udp:PORT (of this machine), - (standard input), or
/// play:SEQUENCE, whose stamps are on this machine's clock.
/// @param line  Nothing for one that is not understood. Errors: kInvalidInput, kNotFound, kIo;
/// those of the sequence; what `line` returns.
Status ReadImuInput(
    const std::string& spec, const RecordWork& work,
    const std::function<Status(const std::optional<ImuLine>& line, std::int64_t arrived_ns)>& line);

/// Whether its stamps are on this machine's clock already.
bool IsPlayed(const std::string& spec);

}  // namespace plumbline
