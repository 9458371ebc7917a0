// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "engine/sensor/camera.h"

namespace plumbline {

/// Resamples images of a distorted camera into its pinhole camera; what the pinhole sees and the
/// recorded image does not stays black. Cheap to copy; safe to use from several threads.
class Undistorter {
 public:
  explicit Undistorter(const Camera& camera);
  /// The image itself where there is no distortion. Image size must be the camera's.
  cv::Mat Undistort(const cv::Mat& image) const;
  /// The same without mixing neighbours, for depth: 0 where nothing was recorded.
  cv::Mat UndistortNearest(const cv::Mat& image) const;

 private:
  cv::Mat map1_, map2_;
};

/// Pinhole pixels of recorded (distorted) pixels; not-a-number where the ray is not in front of the
/// camera or the model has none. The same pixels without distortion.
std::vector<cv::Point2d> UndistortPixels(const Camera& camera, std::vector<cv::Point2d> pixels);

}  // namespace plumbline
