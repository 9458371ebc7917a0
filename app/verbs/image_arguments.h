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

/// The images that the arguments name: files as they are, and for a folder the JPEG and PNG files
/// in it, by name. Errors: kNotFound (nothing there, a folder without images).
Result<std::vector<std::filesystem::path>> ExpandImages(const std::vector<std::string>& arguments);

/// Reads the images one by one, showing progress under `stage`, and hands each to `process`. An
/// image that cannot be read or processed is named on standard error and skipped; the rest go on.
/// Ctrl-C stops after the present one. Errors: kCorrupt if any was skipped (saying how many),
/// kCancelled.
Status ForEachImage(
    const std::vector<std::filesystem::path>& images, std::string_view stage,
    const std::function<Status(const std::filesystem::path& file, const cv::Mat& image)>& process);

}  // namespace plumbline
