// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "app/window/application.h"
#include "engine/base/progress.h"

namespace plumbline {

struct FilmRange {
  std::optional<int> end;  ///< Films frames before this one.
  int step = 1;            ///< Every so many of them.
};

/// Steps from the frame that is shown on, and gives each with its picture. Returns how many.
/// Errors: kCancelled; what the process or `take` fails with.
Result<int> FilmFrames(Application& application, const FilmRange& range, const WorkContext& work,
                       const std::function<Status(const cv::Mat& picture, int frame)>& take);

/// Where the pictures of a film go.
class FilmSink {
 public:
  virtual ~FilmSink() = default;
  virtual Status Take(const cv::Mat& picture, int frame) = 0;
  /// After the last picture. Errors: of the encoder.
  virtual Status Finish() { return {}; }
};
/// FILE.mp4 (OpenCV's encoder), FILE.gif (ffmpeg) or else a folder of PNG. Errors: kUnsupported,
/// kIo.
Result<std::unique_ptr<FilmSink>> OpenFilm(const std::filesystem::path& out, double rate_hz);

struct Film {
  std::filesystem::path video;  ///< Empty if no encoder was at hand.
  std::vector<std::filesystem::path> pictures;
  int frames = 0;
};

/// Everything that is open in `application`: every frame in FOLDER/demo.mp4 at the rate of the
/// sequence, and four frames as PNG. Errors: kIo, kCancelled; what the process fails with.
Result<Film> FilmWindow(Application& application, const std::filesystem::path& folder,
                        const WorkContext& work);

}  // namespace plumbline
