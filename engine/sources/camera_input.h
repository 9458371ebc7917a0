// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/sensor/camera.h"
#include "engine/sources/sensor_work.h"

namespace plumbline {

/// What a V4L2 camera is to expose for, always the same: corners and colours then stay as they are
/// when it looks at a window.
struct Exposure {
  /// 0: what it sets itself to in the first two seconds.
  double milliseconds = 0;
};

struct CameraInput {
  /// A number or /dev/videoN (V4L2), play:SEQUENCE, or what OpenCV opens: a video file, a URL.
  std::string spec;
  std::optional<Exposure> exposure = {};  ///< Nothing: whatever the camera does. V4L2 only.
};

/// As text, that an exposure is left to the camera.
inline constexpr const char* kNoExposure = "auto";

/// `auto`, `lock` (as Exposure of 0), or milliseconds. Errors: kInvalidInput.
Result<std::optional<Exposure>> ParseExposure(const std::string& text);

/// @param camera  What is asked of a V4L2 camera: size and rate.
/// @param image  CV_8UC3 BGR, and when it was taken. Errors: kNotFound, kIo; those of the sequence;
/// what `image` returns.
Status ReadCamera(
    const CameraInput& input, const Camera& camera, const SensorWork& work,
    const std::function<Status(const cv::Mat& picture, std::int64_t stamp_ns)>& image);

}  // namespace plumbline
