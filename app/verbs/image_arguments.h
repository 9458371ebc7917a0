// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// The images and videos that the arguments name: files as they are, and for a folder the JPEG and
/// PNG files in it, by name. Errors: kNotFound (nothing there, a folder without images).
Result<std::vector<std::filesystem::path>> ExpandImages(const std::vector<std::string>& arguments);

/// An image that was named, or a frame of a video.
struct NamedImage {
  std::string name;  ///< The path of the image; of a video's frame, with _NNNNNN before its ending.
  std::string stem;  ///< What files made of it are called, without an ending.
  cv::Mat image;     ///< CV_8UC3.
};

/// Reads the images one by one, videos frame by frame, showing progress under `stage`, and hands
/// each to `process`. An image that cannot be read or processed is named on standard error and
/// skipped; the rest go on. Ctrl-C stops after the present one. Errors: kCorrupt if any was skipped
/// (saying how many), kCancelled.
Status ForEachImage(const std::vector<std::filesystem::path>& files, std::string_view stage,
                    const std::function<Status(const NamedImage& image)>& process);

}  // namespace plumbline
