// SPDX-License-Identifier: Apache-2.0
#include "engine/tracking/point_tracker.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

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

/// Patches are of as many images at most: what is kept in memory.
constexpr std::size_t kPatchImages = 24;
const cv::TermCriteria kStop(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 20, 0.01);

/// Correlation of two patches, whatever their brightness and contrast: 1 where they are alike.
double Likeness(const cv::Mat& one, const cv::Point2f& at, const cv::Mat& other,
                const cv::Point2f& there, const cv::Size& window) {
  cv::Mat a, b, result;
  cv::getRectSubPix(one, window, at, a);
  cv::getRectSubPix(other, window, there, b);
  cv::matchTemplate(a, b, result, cv::TM_CCOEFF_NORMED);
  return result.at<float>(0);
}

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

PointTracker::Pyramid PointTracker::PyramidOf(const cv::Mat& grey) const {
  Pyramid pyramid;
  cv::buildOpticalFlowPyramid(grey, pyramid, {options_.window_px, options_.window_px},
                              options_.levels);
  return pyramid;
}

void PointTracker::Follow(const Pyramid& previous, const Pyramid& present,
                          const Eigen::Matrix3d& previous_from_present) {
  if (tracks_.empty()) return;
  const Eigen::Matrix3d turn = previous_from_present.transpose();
  std::vector<cv::Point2f> from, found;
  for (const FollowedPoint& track : tracks_) {
    from.push_back(track.pixel);
    found.push_back(Predicted(track.pixel, turn));
  }
  std::vector<cv::Point2f> back = from;
  const cv::Size window(options_.window_px, options_.window_px);
  std::vector<unsigned char> forth_ok, back_ok;
  std::vector<float> ignored;
  cv::calcOpticalFlowPyrLK(previous, present, from, found, forth_ok, ignored, window,
                           options_.levels, kStop, cv::OPTFLOW_USE_INITIAL_FLOW);
  // The way back begins from where it should end: one level suffices.
  cv::calcOpticalFlowPyrLK(present, previous, found, back, back_ok, ignored, window,
                           std::min(options_.levels, 1), kStop, cv::OPTFLOW_USE_INITIAL_FLOW);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const cv::Point2f off = back[i] - from[i];
    if (!forth_ok[i] || !back_ok[i] || !Inside(found[i]) ||
        std::hypot(off.x, off.y) > options_.round_trip_px)
      continue;
    tracks_[i].pixel = found[i];
    std::swap(tracks_[kept++], tracks_[i]);
  }
  tracks_.resize(kept);
}

void PointTracker::AlignWithPatches(const Pyramid& present) {
  if (options_.patch_likeness > 1) {
    for (FollowedPoint& track : tracks_) track.patch.image = nullptr;
    return;
  }
  std::map<std::int64_t, std::vector<FollowedPoint*>> of_image;
  for (FollowedPoint& track : tracks_) of_image[track.patch.image_number].push_back(&track);
  for (; of_image.size() > kPatchImages; of_image.erase(of_image.begin())) {
    for (FollowedPoint* track : of_image.begin()->second) track->patch.image = nullptr;
  }
  const cv::Size window(options_.window_px, options_.window_px);
  for (const auto& [number, tracks] : of_image) {
    const std::shared_ptr<const Pyramid> kept = tracks.front()->patch.image;
    const Pyramid& image = *kept;
    std::vector<cv::Point2f> from, found;
    for (const FollowedPoint* track : tracks) {
      from.push_back(track->patch.pixel);
      found.push_back(track->pixel);
    }
    std::vector<unsigned char> ok;
    std::vector<float> ignored;
    cv::calcOpticalFlowPyrLK(image, present, from, found, ok, ignored, window, 0, kStop,
                             cv::OPTFLOW_USE_INITIAL_FLOW);
    for (std::size_t i = 0; i < tracks.size(); ++i) {
      const cv::Point2f off = found[i] - tracks[i]->pixel;
      if (ok[i] && Inside(found[i]) && std::hypot(off.x, off.y) <= options_.patch_reach_px &&
          Likeness(image[0], from[i], present[0], found[i], window) >= options_.patch_likeness) {
        tracks[i]->pixel = found[i];
      } else {
        tracks[i]->patch.image = nullptr;
      }
    }
  }
}

void PointTracker::Detect(const cv::Mat& image) {
  const int missing = options_.points - static_cast<int>(tracks_.size());
  if (missing <= options_.points / 10) return;
  const double spacing = options_.spacing_px * size_.width / kWidthOfSpacing;
  cv::Mat small;
  cv::resize(image, small, {}, 1.0 / kDetectShrink, 1.0 / kDetectShrink, cv::INTER_AREA);
  cv::Mat mask(small.size(), CV_8UC1, cv::Scalar(255));
  const float shift = (kDetectShrink - 1) / 2.0f;  // pixel centres are at integers
  for (const FollowedPoint& track : tracks_) {
    cv::circle(mask, (track.pixel - cv::Point2f(shift, shift)) / kDetectShrink,
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
    tracks_.push_back({next_id_++, corner, {}});
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
  const auto pyramid = std::make_shared<const Pyramid>(PyramidOf(grey));
  if (light_jump_ != 1 && pyramid_) {
    Follow(PyramidOf(EvenedOut((*pyramid_)[0])), PyramidOf(EvenedOut(grey)), previous_from_present);
    for (FollowedPoint& track : tracks_) track.patch.image = nullptr;
  } else if (pyramid_) {
    Follow(*pyramid_, *pyramid, previous_from_present);
    AlignWithPatches(*pyramid);
  }
  mean_ = mean;
  cost_.track_ms = watch.Lap();
  Detect(grey);
  for (FollowedPoint& track : tracks_) {
    if (!track.patch.image) track.patch = {pyramid, image_number_, track.pixel};
  }
  pyramid_ = pyramid;
  ++image_number_;
  cost_.detect_ms = watch.Lap();
  TrackedImage result;
  result.stamp_ns = stamp_ns;
  for (const FollowedPoint& track : tracks_)
    result.points.push_back({track.id, {track.pixel.x, track.pixel.y}});
  return result;
}

}  // namespace plumbline
