// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/sensor/image_file.h"

namespace plumbline {

/// Decodes the bytes of a JPEG or PNG file that lie inside of something else, as ReadImage does.
/// @param name  For messages, in place of the file's.
Result<cv::Mat> DecodeImage(const std::string& bytes, ImageKind kind, std::optional<cv::Size> size,
                            const std::string& name);

}  // namespace plumbline
