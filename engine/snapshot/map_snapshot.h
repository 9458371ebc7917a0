// SPDX-License-Identifier: Apache-2.0
#pragma once

// What crosses to the window with every frame. Values only, shared and never written after
// publication. It includes mapping/map_report.h, which is values only too (a departure from the
// house rule: the alternative was to declare every field twice); headers that only pass a frame on
// declare MapSnapshot instead of including this.

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/base/ids.h"
#include "engine/mapping/map_report.h"

namespace plumbline {

/// Polyline of an object's mean outline in the image [px].
struct OutlineView {
  ObjectId object;
  std::vector<std::vector<Eigen::Vector2f>> contours;
};

/// One frame as the mapper left it: images are shared, not copied.
struct MapSnapshot {
  FrameReport report;
  cv::Mat image;                         ///< CV_8UC3 BGR
  cv::Mat edge_probability, edge_angle;  ///< CV_8U (see EdgeMap)
  cv::Mat depth;  ///< CV_32F Z-buffer of the mean states [m], 0 none; same aspect as the image,
                  ///< maybe half size
  cv::Mat id;     ///< CV_16U object id of the Z-buffer
  std::vector<OutlineView> outlines;
};

}  // namespace plumbline
