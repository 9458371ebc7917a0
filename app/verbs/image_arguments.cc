// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/image_arguments.h"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <iostream>
#include <iterator>

#include <opencv2/videoio.hpp>

#include "app/verbs/console_work.h"
#include "engine/sensor/image_file.h"

namespace plumbline {

Result<std::vector<std::filesystem::path>> ExpandImages(const std::vector<std::string>& arguments) {
  std::vector<std::filesystem::path> images;
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (!std::filesystem::is_directory(argument, error)) {
      if (!std::filesystem::exists(argument, error)) {
        return Error{ErrorCode::kNotFound, "there is no image, video or folder '" + argument + "'"};
      }
      images.emplace_back(argument);
      continue;
    }
    std::vector<std::filesystem::path> inside;
    for (std::filesystem::directory_iterator entry(argument, error), end; !error && entry != end;
         entry.increment(error)) {
      if (IsImageName(entry->path())) inside.push_back(entry->path());
    }
    if (inside.empty()) {
      return Error{ErrorCode::kNotFound,
                   "the folder '" + argument + "' holds no JPEG or PNG image" +
                       (std::filesystem::exists(std::filesystem::path(argument) / "color", error)
                            ? "; those of a sequence are in its folder color"
                            : "")};
    }
    std::sort(inside.begin(), inside.end());
    images.insert(images.end(), inside.begin(), inside.end());
  }
  return images;
}

namespace {

bool IsVideoName(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::string_view kEndings[] = {".mp4", ".avi", ".mov", ".mkv", ".webm", ".m4v"};
  return std::find(std::begin(kEndings), std::end(kEndings), ending) != std::end(kEndings);
}

/// Opens a video; its frames come as they are stored, whatever the tag of their orientation.
Result<cv::VideoCapture> OpenVideo(const std::filesystem::path& file) {
  cv::VideoCapture video(file.string());
  if (!video.isOpened()) {
    return Error{ErrorCode::kCorrupt,
                 "'" + file.string() + "' is no video that this machine can decode"};
  }
  video.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
  return video;
}

/// Goes through all images and keeps count.
class Walk {
 public:
  Walk(std::string_view stage, const std::function<Status(const NamedImage& image)>& process)
      : stage_(stage), process_(process), work_(console_.context()) {}

  void Expect(int images) { total_ += images; }
  bool interrupted() const { return console_.interrupted(); }
  /// @param image  Or why there is none.
  void Take(const std::string& name, const std::string& stem, const Result<cv::Mat>& image) {
    work_.report({stage_, done_, std::max(total_, done_ + 1)});
    const Status status = image.ok() ? process_({name, stem, *image}) : Status(image.error());
    ++done_;
    if (status.ok()) return;
    std::cerr << "plumbline: " << status.error().message << "; skipped" << std::endl;
    ++skipped_;
  }
  Status Finish() const {
    if (interrupted()) {
      return Error{ErrorCode::kCancelled, "stopped after " + std::to_string(done_) + " of " +
                                              std::to_string(total_) + " images"};
    }
    work_.report({stage_, done_, done_});
    if (skipped_ == 0) return {};
    return Error{ErrorCode::kCorrupt, std::to_string(skipped_) + " of " + std::to_string(done_) +
                                          " images were skipped; the rest are done"};
  }

 private:
  std::string_view stage_;
  const std::function<Status(const NamedImage& image)>& process_;
  ConsoleWork console_;
  WorkContext work_;
  int total_ = 0, done_ = 0, skipped_ = 0;
};

void TakeVideo(const std::filesystem::path& file, Walk& walk) {
  Result<cv::VideoCapture> video = OpenVideo(file);
  if (!video.ok()) return walk.Take(file.string(), file.stem().string(), video.error());
  cv::Mat image;
  for (int frame = 0; !walk.interrupted() && video->read(image); ++frame) {
    char number[16];
    std::snprintf(number, sizeof(number), "_%06d", frame);
    const std::string stem = file.stem().string() + number;
    walk.Take((file.parent_path() / (stem + file.extension().string())).string(), stem,
              image.clone());
  }
}

}  // namespace

Status ForEachImage(const std::vector<std::filesystem::path>& files, std::string_view stage,
                    const std::function<Status(const NamedImage& image)>& process) {
  Walk walk(stage, process);
  for (const std::filesystem::path& file : files) {
    int images = 1;
    if (IsVideoName(file)) {
      if (const auto video = OpenVideo(file); video.ok())
        images = std::max(1, static_cast<int>(video->get(cv::CAP_PROP_FRAME_COUNT)));
    }
    walk.Expect(images);
  }
  for (const std::filesystem::path& file : files) {
    if (walk.interrupted()) break;
    if (IsVideoName(file)) {
      TakeVideo(file, walk);
    } else {
      walk.Take(file.string(), file.stem().string(), ReadImage(file, ImageKind::kColor));
    }
  }
  return walk.Finish();
}

}  // namespace plumbline
