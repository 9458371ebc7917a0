// SPDX-License-Identifier: Apache-2.0
#include "app/film.h"

#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <thread>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

namespace plumbline {
namespace {

constexpr int kPictures = 4;

/// Draws until `done` or a failure. The last picture is in `picture`.
Status DrawUntil(Application& application, const WorkContext& work, cv::Mat& picture,
                 const std::function<bool()>& done) {
  std::string told;
  while (!work.stop.stop_requested()) {
    application.DrawFrame(&picture);
    const PlaybackView& playback = *application.context().playback;
    if (playback.state == PlaybackState::kFailed) return Error{ErrorCode::kIo, playback.message};
    if (done()) return {};
    if (application.context().sequence == nullptr && playback.message != told) {
      told = playback.message;
      work.report({told});
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return Error{ErrorCode::kCancelled, "stopped; what was filmed is kept"};
}

cv::VideoWriter OpenVideo(const std::filesystem::path& file, double rate_hz, cv::Size size) {
  for (const int code :
       {cv::VideoWriter::fourcc('a', 'v', 'c', '1'), cv::VideoWriter::fourcc('m', 'p', '4', 'v')}) {
    cv::VideoWriter writer(file.string(), code, rate_hz, size);
    if (writer.isOpened()) return writer;
  }
  return {};
}

}  // namespace

Result<Film> FilmWindow(Application& application, const std::filesystem::path& folder,
                        const WorkContext& work) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return Error{ErrorCode::kIo,
                 "cannot make the folder '" + folder.string() + "': " + error.message()};
  const FrameContext& context = application.context();
  cv::Mat picture;
  Status status =
      DrawUntil(application, work, picture, [&] { return context.snapshot != nullptr; });
  if (!status.ok()) return status.error();

  Film film;
  const std::filesystem::path video = folder / "demo.mp4";
  cv::VideoWriter writer = OpenVideo(video, context.sequence->rate_hz, picture.size());
  const int total = context.sequence->num_frames;
  int pictures_done = 0;
  while (true) {
    application.DrawFrame(&picture);  // once more: ImGui lays some things out a frame later
    if (writer.isOpened()) writer.write(picture);
    ++film.frames;
    work.report({"filming the window", film.frames, total});
    const bool last = context.playback->state == PlaybackState::kFinished;
    if (film.frames * kPictures >= (pictures_done + 1) * total || last) {
      ++pictures_done;
      film.pictures.push_back(folder / fmt::format("window-{:04d}.png", context.playback->frame));
      if (!cv::imwrite(film.pictures.back().string(), picture)) {
        return Error{ErrorCode::kIo, "cannot write '" + film.pictures.back().string() + "'"};
      }
    }
    if (last) break;
    const int before = context.playback->frame;
    application.process()->Post(StepCommand{1});
    status = DrawUntil(application, work, picture, [&] {
      return context.playback->frame != before &&
             context.snapshot->report.frame == context.playback->frame;
    });
    if (!status.ok()) return status.error();
  }
  if (writer.isOpened()) film.video = video;
  return film;
}

}  // namespace plumbline
