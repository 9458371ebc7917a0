// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/models/model_builder.h"

namespace plumbline {

/// Appends a row of thumbnails for each thing that is unsure about the model: standing on each of
/// its six sides, or facing the camera with each of its four; with the option to state it by and
/// the share of the guess. CV_8UC3, BGR, all rows of one width.
void AddQuestions(const BuiltModel& built, std::vector<cv::Mat>& rows);

}  // namespace plumbline
