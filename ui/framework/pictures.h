// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

#include <imgui.h>
#include <opencv2/core.hpp>

#include "engine/snapshot/object_look.h"

namespace plumbline {

// Pictures (CV_8UC3 BGR) of the maps of a snapshot. Empty maps give empty pictures.

/// Orientation of the edge as hue, probability as value. Both CV_8U. `thick`: lines of two pixels.
cv::Mat EdgePicture(const cv::Mat& probability, const cv::Mat& angle, bool thick = false);
/// Colour of an orientation in [0, pi).
ImU32 OrientationColor(double angle_rad);

/// Nearest and farthest depth in a Z-buffer, widened to whole half metres; {0, 0} if it is empty.
struct DepthRange {
  double near_m = 0, far_m = 0;
  bool empty() const { return far_m <= near_m; }
};
DepthRange RangeOf(const cv::Mat& depth);
/// Near bright, far dark, nothing black (viridis).
cv::Mat DepthPicture(const cv::Mat& depth, const DepthRange& range);
ImU32 DepthColor(double depth_m, const DepthRange& range);

/// The dimmed image with the objects' masks in their colours, darker the closer.
cv::Mat MaskPicture(const cv::Mat& image, const cv::Mat& depth, const cv::Mat& id,
                    const DepthRange& range, const ObjectLooks& looks);

}  // namespace plumbline
