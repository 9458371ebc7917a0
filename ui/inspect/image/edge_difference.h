// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>

namespace plumbline {

struct MapSnapshot;

/// Edges against the contours that the mean states make expect, as a picture (CV_8UC3): green edges
/// that an expected contour explains, grey ones that none does, red contour without an edge nearby.
/// "Nearby" is within 5 pixels.
cv::Mat EdgeDifferencePicture(const MapSnapshot& snapshot);

}  // namespace plumbline
