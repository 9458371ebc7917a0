// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/image_arguments.h"

#include <algorithm>
#include <iostream>

#include "app/verbs/console_work.h"
#include "engine/sensor/image_file.h"

namespace plumbline {

Result<std::vector<std::filesystem::path>> ExpandImages(const std::vector<std::string>& arguments) {
  std::vector<std::filesystem::path> images;
  for (const std::string& argument : arguments) {
    std::error_code error;
    if (!std::filesystem::is_directory(argument, error)) {
      if (!std::filesystem::exists(argument, error)) {
        return Error{ErrorCode::kNotFound, "there is no image or folder '" + argument + "'"};
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

Status ForEachImage(
    const std::vector<std::filesystem::path>& images, std::string_view stage,
    const std::function<Status(const std::filesystem::path& file, const cv::Mat& image)>& process) {
  ConsoleWork console;
  const WorkContext work = console.context();
  const int total = static_cast<int>(images.size());
  int skipped = 0;
  for (int i = 0; i < total; ++i) {
    if (console.interrupted()) {
      return Error{ErrorCode::kCancelled, "stopped after " + std::to_string(i) + " of " +
                                              std::to_string(total) + " images"};
    }
    work.report({stage, i, total});
    const Result<cv::Mat> image = ReadImage(images[i], ImageKind::kColor);
    const Status status = image.ok() ? process(images[i], *image) : Status(image.error());
    if (status.ok()) continue;
    std::cerr << "plumbline: " << status.error().message << "; skipped" << std::endl;
    ++skipped;
  }
  work.report({stage, total, total});
  if (skipped == 0) return {};
  return Error{ErrorCode::kCorrupt, std::to_string(skipped) + " of " + std::to_string(total) +
                                        " images were skipped; the rest are done"};
}

}  // namespace plumbline
