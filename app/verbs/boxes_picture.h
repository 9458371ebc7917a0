// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include <opencv2/core.hpp>

#include "engine/dataset/sequence.h"

namespace plumbline {

/// Draws boxes with category and score into a CV_8UC3 image, a colour for each category.
void DrawBoxes(std::span<const Detection> boxes, cv::Mat& picture);

}  // namespace plumbline
