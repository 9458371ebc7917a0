// SPDX-License-Identifier: Apache-2.0
#include "engine/tracking/point_tracker.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

#include "engine/base/check.h"
#include "engine/base/timer.h"

namespace plumbline {
namespace {

/// Corners are sought in an image of this share: quicker, and what survives blur.
constexpr int kDetectShrink = 2;
constexpr int kBorder = 4;  ///< Points nearer to the edge of the image are dropped [px].
constexpr double kWidthOfSpacing = 640;
/// A change of the mean grey level from image to image by more than this share is a jump.
constexpr double kLightJump = 0.12;

/// The image with the mean and the contrast of each neighbourhood evened out: what light from
/// another side leaves as it is. Costs some ms.
cv::Mat EvenedOut(const cv::Mat& grey) {
  constexpr int kSide = 25;
  constexpr double kContrast = 40, kNoise = 6;  // [grey levels]
  cv::Mat image, mean, square;
  grey.convertTo(image, CV_32F);
  cv::boxFilter(image, mean, CV_32F, {kSide, kSide});
  cv::sqrBoxFilter(image, square, CV_32F, {kSide, kSide});
  cv::Mat deviation = cv::max(square - mean.mul(mean), 0);
  cv::sqrt(deviation, deviation);
  cv::Mat even, result;
  cv::divide(image - mean, deviation + kNoise, even, kContrast);
  even.convertTo(result, CV_8U, 1, 128);
  return result;
}

}  // namespace

PointTracker::PointTracker(const Camera& camera, const TrackerOptions& options)
    : camera_(camera), size_(camera.pinhole.width, camera.pinhole.height), options_(options) {}

bool PointTracker::Inside(const cv::Point2f& pixel) const {
  return pixel.x >= kBorder && pixel.y >= kBorder && pixel.x < size_.width - kBorder &&
         pixel.y < size_.height - kBorder;
}

cv::Point2f PointTracker::Predicted(const cv::Point2f& pixel,
                                    const Eigen::Matrix3d& present_from_previous) const {
  const auto ray = camera_.Unproject({pixel.x, pixel.y});
  if (!ray) return pixel;
  const auto projection = camera_.Project(present_from_previous * *ray);
  if (!projection) return pixel;
  const cv::Point2f moved(static_cast<float>(projection->pixel.x()),
                          static_cast<float>(projection->pixel.y()));
  return Inside(moved) ? moved : pixel;
}

std::vector<cv::Mat> PointTracker::PyramidOf(const cv::Mat& grey) const {
  std::vector<cv::Mat> pyramid;
  cv::buildOpticalFlowPyramid(grey, pyramid, {options_.window_px, options_.window_px},
                              options_.levels);
  return pyramid;
}

void PointTracker::Follow(const std::vector<cv::Mat>& previous, const std::vector<cv::Mat>& present,
                          const Eigen::Matrix3d& previous_from_present) {
  if (pixels_.empty()) return;
  const Eigen::Matrix3d turn = previous_from_present.transpose();
  std::vector<cv::Point2f> found, back = pixels_;
  for (const cv::Point2f& pixel : pixels_) found.push_back(Predicted(pixel, turn));
  const cv::Size window(options_.window_px, options_.window_px);
  const cv::TermCriteria stop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);
  std::vector<unsigned char> forth_ok, back_ok;
  std::vector<float> ignored;
  cv::calcOpticalFlowPyrLK(previous, present, pixels_, found, forth_ok, ignored, window,
                           options_.levels, stop, cv::OPTFLOW_USE_INITIAL_FLOW);
  // The way back begins from where it should end: one level suffices.
  cv::calcOpticalFlowPyrLK(present, previous, found, back, back_ok, ignored, window,
                           std::min(options_.levels, 1), stop, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pixels_.size(); ++i) {
    const cv::Point2f off = back[i] - pixels_[i];
    if (!forth_ok[i] || !back_ok[i] || !Inside(found[i]) ||
        std::hypot(off.x, off.y) > options_.round_trip_px)
      continue;
    ids_[kept] = ids_[i];
    pixels_[kept++] = found[i];
  }
  ids_.resize(kept);
  pixels_.resize(kept);
}

void PointTracker::Detect(const cv::Mat& image) {
  const int missing = options_.points - static_cast<int>(pixels_.size());
  if (missing <= options_.points / 10) return;
  const double spacing = options_.spacing_px * size_.width / kWidthOfSpacing;
  cv::Mat small;
  cv::resize(image, small, {}, 1.0 / kDetectShrink, 1.0 / kDetectShrink, cv::INTER_AREA);
  cv::Mat mask(small.size(), CV_8UC1, cv::Scalar(255));
  const float shift = (kDetectShrink - 1) / 2.0f;  // pixel centres are at integers
  for (const cv::Point2f& pixel : pixels_) {
    cv::circle(mask, (pixel - cv::Point2f(shift, shift)) / kDetectShrink,
               static_cast<int>(spacing / kDetectShrink), cv::Scalar(0), cv::FILLED);
  }
  std::vector<cv::Point2f> corners;
  cv::goodFeaturesToTrack(small, corners, missing, options_.corner_quality, spacing / kDetectShrink,
                          mask, 5);
  if (corners.empty()) return;
  for (cv::Point2f& corner : corners) corner = corner * kDetectShrink + cv::Point2f(shift, shift);
  cv::cornerSubPix(image, corners, {3, 3}, {-1, -1},
                   {cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 10, 0.02});
  for (const cv::Point2f& corner : corners) {
    if (!Inside(corner)) continue;
    pixels_.push_back(corner);
    ids_.push_back(next_id_++);
  }
}

TrackedImage PointTracker::Track(const cv::Mat& image, std::int64_t stamp_ns,
                                 const Eigen::Matrix3d& previous_from_present) {
  PLB_CHECK(image.size() == size_) << "an image of another size than the camera's";
  Stopwatch watch;
  cv::Mat grey;
  if (image.channels() == 3) {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  } else {
    grey = image.clone();
  }
  // A change of exposure would look like motion: every image gets the mean of the first.
  const double mean = std::max(cv::mean(grey)[0], 1.0);
  if (brightness_ <= 0) brightness_ = std::clamp(mean, 60.0, 160.0);
  const double gain = std::clamp(brightness_ / mean, 0.25, 4.0);
  if (std::abs(gain - 1) > 0.01) grey.convertTo(grey, -1, gain);
  const double change = mean_ > 0 ? mean / mean_ : 1;
  light_jump_ = std::abs(std::log(change)) > kLightJump ? change : 1;
  std::vector<cv::Mat> pyramid = PyramidOf(grey);
  if (light_jump_ != 1 && !grey_.empty()) {
    Follow(PyramidOf(EvenedOut(grey_)), PyramidOf(EvenedOut(grey)), previous_from_present);
  } else if (!pyramid_.empty()) {
    Follow(pyramid_, pyramid, previous_from_present);
  }
  mean_ = mean;
  grey_ = grey;
  cost_.track_ms = watch.Lap();
  Detect(grey);
  pyramid_ = std::move(pyramid);
  cost_.detect_ms = watch.Lap();
  TrackedImage result;
  result.stamp_ns = stamp_ns;
  for (std::size_t i = 0; i < pixels_.size(); ++i)
    result.points.push_back({ids_[i], {pixels_[i].x, pixels_[i].y}});
  return result;
}

}  // namespace plumbline
