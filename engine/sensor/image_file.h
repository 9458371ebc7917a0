// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include <opencv2/core.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// Whether the name ends as those of JPEG and PNG files do, in any case.
bool IsImageName(const std::filesystem::path& file);

enum class ImageKind { kColor, kGray, kDepth };

/// Decodes a JPEG or PNG file, told apart by content, to CV_8UC3 BGR (kColor), CV_8UC1 (kGray) or
/// CV_16UC1 (kDepth: a PNG of 16 bits, as it is stored).
/// The orientation tag of photographs is ignored: calibrations hold for the pixels as stored.
/// Unlike cv::imread, a file of which only a part can be decoded is an error. A `size` is checked
/// before any memory is taken. Errors: kNotFound, kCorrupt (truncated, damaged), kInvalidInput
/// (another size), kUnsupported (another format).
Result<cv::Mat> ReadImage(const std::filesystem::path& file, ImageKind kind,
                          std::optional<cv::Size> size = std::nullopt);

}  // namespace plumbline
