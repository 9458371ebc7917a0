// SPDX-License-Identifier: Apache-2.0
#include "app/film/film.h"

#include <fmt/format.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "engine/snapshot/map_snapshot.h"

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

Status MakeFolder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return {};
  return Error{ErrorCode::kIo,
               "cannot make the folder '" + folder.string() + "': " + error.message()};
}

cv::VideoWriter OpenVideo(const std::filesystem::path& file, double rate_hz, cv::Size size) {
  for (const int code :
       {cv::VideoWriter::fourcc('a', 'v', 'c', '1'), cv::VideoWriter::fourcc('m', 'p', '4', 'v')}) {
    cv::VideoWriter writer(file.string(), code, rate_hz, size);
    if (writer.isOpened()) return writer;
  }
  return {};
}

class VideoSink : public FilmSink {
 public:
  VideoSink(std::filesystem::path file, double rate_hz)
      : file_(std::move(file)), rate_hz_(rate_hz) {}
  Status Take(const cv::Mat& picture, int) override {
    const cv::Rect even(0, 0, picture.cols & ~1, picture.rows & ~1);  // encoders want it so
    if (!writer_.isOpened()) writer_ = OpenVideo(file_, rate_hz_, even.size());
    if (!writer_.isOpened())
      return Error{ErrorCode::kUnsupported,
                   "cannot write '" + file_.string() +
                       "': OpenCV has no encoder for MP4 here, or the folder is not writable; name "
                       "a folder with --out to get pictures"};
    writer_.write(picture(even));
    return {};
  }

 private:
  std::filesystem::path file_;
  double rate_hz_;
  cv::VideoWriter writer_;
};

class FolderSink : public FilmSink {
 public:
  explicit FolderSink(std::filesystem::path folder) : folder_(std::move(folder)) {}
  Status Take(const cv::Mat& picture, int frame) override {
    const auto file = folder_ / fmt::format("{:06d}.png", frame);
    if (cv::imwrite(file.string(), picture)) return {};
    return Error{ErrorCode::kIo, "cannot write '" + file.string() + "'"};
  }

 private:
  std::filesystem::path folder_;
};

/// Collects pictures in a temporary folder and lets ffmpeg choose the colours.
class GifSink : public FilmSink {
 public:
  static Result<std::unique_ptr<FilmSink>> Open(const std::filesystem::path& file, double rate_hz) {
    std::string folder = (std::filesystem::temp_directory_path() / "plumbline_XXXXXX").string();
    if (mkdtemp(folder.data()) == nullptr)
      return Error{ErrorCode::kIo, "cannot make a temporary folder for '" + file.string() + "'"};
    return std::unique_ptr<FilmSink>(new GifSink(file, folder, rate_hz));
  }
  ~GifSink() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder_, ignored);
  }
  Status Take(const cv::Mat& picture, int) override {
    const auto file = folder_ / fmt::format("{:06d}.png", count_++);
    if (cv::imwrite(file.string(), picture)) return {};
    return Error{ErrorCode::kIo, "cannot write '" + file.string() + "'"};
  }
  Status Finish() override {
    const std::string rate = fmt::format("{:g}", rate_hz_);
    const std::string pictures = (folder_ / "%06d.png").string();
    const pid_t child = fork();
    if (child == 0) {
      execlp("ffmpeg", "ffmpeg", "-v", "error", "-y", "-framerate", rate.c_str(), "-i",
             pictures.c_str(), "-vf",
             "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer:"
             "bayer_scale=4:diff_mode=rectangle",
             file_.c_str(), static_cast<char*>(nullptr));
      _exit(127);
    }
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) < 0 || !WIFEXITED(status))
      return Error{ErrorCode::kIo, "ffmpeg was ended while it wrote '" + file_.string() + "'"};
    if (WEXITSTATUS(status) == 127)
      return Error{ErrorCode::kUnsupported,
                   "GIF needs ffmpeg, which is not installed (Debian: apt-get install ffmpeg)"};
    if (WEXITSTATUS(status) == 0) return {};
    return Error{ErrorCode::kIo, "ffmpeg could not write '" + file_.string() + "'"};
  }

 private:
  GifSink(std::filesystem::path file, std::filesystem::path folder, double rate_hz)
      : file_(std::move(file)), folder_(std::move(folder)), rate_hz_(rate_hz) {}
  std::filesystem::path file_, folder_;
  double rate_hz_;
  int count_ = 0;
};

}  // namespace

Result<std::unique_ptr<FilmSink>> OpenFilm(const std::filesystem::path& out, double rate_hz) {
  const auto extension = out.extension();
  const bool is_file = extension == ".mp4" || extension == ".gif";
  const auto folder = is_file ? out.parent_path() : out;
  if (!folder.empty()) {
    if (Status status = MakeFolder(folder); !status.ok()) return status.error();
  }
  if (extension == ".gif") return GifSink::Open(out, rate_hz);
  if (is_file) return std::unique_ptr<FilmSink>(std::make_unique<VideoSink>(out, rate_hz));
  return std::unique_ptr<FilmSink>(std::make_unique<FolderSink>(out));
}

Result<int> FilmFrames(Application& application, const FilmRange& range, const WorkContext& work,
                       const std::function<Status(const cv::Mat& picture, int frame)>& take) {
  const FrameContext& context = application.context();
  cv::Mat picture;
  const auto shown = [&] {
    return context.snapshot != nullptr && !context.playback->seek_target &&
           context.snapshot->report.frame == context.playback->frame;
  };
  Status status = DrawUntil(application, work, picture, shown);
  if (!status.ok()) return status.error();
  const int first = context.playback->frame;
  const int end =
      std::min(range.end.value_or(context.sequence->num_frames), context.sequence->num_frames);
  int count = 0;
  while (context.playback->frame < end) {
    application.DrawFrame(&picture);  // once more: ImGui lays some things out a frame later
    const int frame = context.playback->frame;
    if (status = take(picture, frame); !status.ok()) return status.error();
    ++count;
    work.report({"filming the window", frame - first + 1, std::max(end - first, 1)});
    if (context.playback->state == PlaybackState::kFinished) break;
    application.Post(StepCommand{range.step});
    status = DrawUntil(application, work, picture,
                       [&] { return context.playback->frame != frame && shown(); });
    if (!status.ok()) return status.error();
  }
  return count;
}

Result<Film> FilmWindow(Application& application, const std::filesystem::path& folder,
                        const WorkContext& work) {
  if (Status status = MakeFolder(folder); !status.ok()) return status.error();
  Film film;
  const std::filesystem::path video = folder / "demo.mp4";
  cv::VideoWriter writer;
  const auto take = [&](const cv::Mat& picture, int frame) -> Status {
    const SequenceView& sequence = *application.context().sequence;
    if (film.frames == 0) writer = OpenVideo(video, sequence.rate_hz, picture.size());
    if (writer.isOpened()) writer.write(picture);
    ++film.frames;
    const auto wanted = static_cast<int>(film.pictures.size()) + 1;
    if (film.frames * kPictures < wanted * sequence.num_frames) return {};
    film.pictures.push_back(folder / fmt::format("window-{:04d}.png", frame));
    if (cv::imwrite(film.pictures.back().string(), picture)) return {};
    return Error{ErrorCode::kIo, "cannot write '" + film.pictures.back().string() + "'"};
  };
  const auto filmed = FilmFrames(application, {}, work, take);
  if (!filmed.ok()) return filmed.error();
  if (writer.isOpened()) film.video = video;
  return film;
}

}  // namespace plumbline
