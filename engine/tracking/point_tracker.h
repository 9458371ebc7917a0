// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "engine/dataset/tracks_file.h"
#include "engine/sensor/distorted_camera.h"
#include "engine/tracking/tracker_options.h"

namespace plumbline {

/// What one image cost.
struct TrackingCost {
  double track_ms = 0, detect_ms = 0;
};

/// Follows corners from image to image by pyramidal Lucas-Kanade (OpenCV), in the image as
/// recorded. Corners are spread over the image; a track whose way back does not end where it began
/// is dropped. Numbers of tracks are never used again. Single-threaded, deterministic.
class PointTracker {
 public:
  PointTracker(const Camera& camera, const TrackerOptions& options);

  /// The points of the next image.
  /// @param image  CV_8UC3 BGR or CV_8UC1, of the camera's size.
  /// @param previous_from_present  Rotation of the camera since the last image, as a gyro says:
  ///        where the search begins. The identity serves slow motion.
  TrackedImage Track(const cv::Mat& image, std::int64_t stamp_ns,
                     const Eigen::Matrix3d& previous_from_present);

  const TrackingCost& cost() const { return cost_; }
  /// How much brighter the last image was than the one before, where that was a jump: a lamp, the
  /// sun, the exposure. 1 otherwise.
  double light_jump() const { return light_jump_; }

 private:
  std::vector<cv::Mat> PyramidOf(const cv::Mat& grey) const;
  void Follow(const std::vector<cv::Mat>& previous, const std::vector<cv::Mat>& present,
              const Eigen::Matrix3d& previous_from_present);
  void Detect(const cv::Mat& image);
  cv::Point2f Predicted(const cv::Point2f& pixel,
                        const Eigen::Matrix3d& present_from_previous) const;
  bool Inside(const cv::Point2f& pixel) const;

  DistortedCamera camera_;
  cv::Size size_;
  TrackerOptions options_;
  std::vector<cv::Mat> pyramid_;  ///< Of the last image.
  cv::Mat grey_;                  ///< The last image.
  double brightness_ = 0;         ///< Mean grey level that images are brought to.
  double mean_ = 0;               ///< Mean grey level of the last image.
  double light_jump_ = 1;
  std::vector<cv::Point2f> pixels_;
  std::vector<std::int64_t> ids_;
  std::int64_t next_id_ = 0;
  TrackingCost cost_;
};

}  // namespace plumbline
