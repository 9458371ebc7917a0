// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/ids.h"

namespace plumbline {

struct MapSnapshot;

/// Edges against the contours that the mean states make expect, as a picture (CV_8UC3): green edges
/// that an expected contour explains, grey ones that none does, red contour without an edge nearby.
/// "Nearby" is within 5 pixels.
/// @param left_out  Objects whose contours do not count.
cv::Mat EdgeDifferencePicture(const MapSnapshot& snapshot, const std::vector<ObjectId>& left_out);

}  // namespace plumbline
