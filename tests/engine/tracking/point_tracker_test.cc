// SPDX-License-Identifier: Apache-2.0
#include "engine/tracking/point_tracker.h"

#include <map>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"

namespace plumbline {
namespace {

Camera SomeCamera() {
  Camera camera;
  camera.pinhole = {320, 240, 250, 250, 159.5, 119.5};
  return camera;
}

/// Blobs at random places, moved by (dx, dy) and brighter by `gain`.
cv::Mat Blobs(double dx, double dy, double gain) {
  constexpr int kMargin = 50;
  cv::Mat wide(240 + 2 * kMargin, 320 + 2 * kMargin, CV_32FC1, cv::Scalar(60));
  Random random({7});
  for (int i = 0; i < 400; ++i) {
    const auto pixel = [&](int size) { return static_cast<int>(random.Index(size)); };
    const cv::Rect blob(pixel(wide.cols), pixel(wide.rows), 4 + pixel(10), 4 + pixel(10));
    cv::rectangle(wide, blob, cv::Scalar(random.Uniform(20, 180)), cv::FILLED);
  }
  cv::GaussianBlur(wide, wide, {0, 0}, 1.2);
  const cv::Matx23d move(1, 0, dx, 0, 1, dy);
  cv::Mat moved;
  cv::warpAffine(wide, moved, move, wide.size(), cv::INTER_CUBIC);
  cv::Mat result;
  moved(cv::Rect(kMargin, kMargin, 320, 240)).convertTo(result, CV_8UC1, gain);
  return result;
}

std::map<std::int64_t, Eigen::Vector2d> ById(const TrackedImage& image) {
  std::map<std::int64_t, Eigen::Vector2d> points;
  for (const TrackedPoint& point : image.points) points[point.id] = point.pixel;
  return points;
}

void ExpectMoved(const TrackedImage& before, const TrackedImage& after, const Eigen::Vector2d& by) {
  const auto from = ById(before), to = ById(after);
  int common = 0, close = 0;
  for (const auto& [id, pixel] : from) {
    const auto found = to.find(id);
    if (found == to.end()) continue;
    ++common;
    close += (found->second - pixel - by).norm() < 0.25
                 ? 1
                 : 0;  // of grey levels that are whole numbers
  }
  EXPECT_GT(common, 30);
  EXPECT_GE(close, 0.9 * common);
}

TEST(PointTracker, FollowsAMovedImage) {
  PointTracker tracker(SomeCamera(), TrackerOptions());
  const TrackedImage first = tracker.Track(Blobs(0, 0, 1), 0, Eigen::Matrix3d::Identity());
  const TrackedImage second = tracker.Track(Blobs(3.5, -2.25, 1), 1, Eigen::Matrix3d::Identity());
  EXPECT_EQ(second.stamp_ns, 1);
  ExpectMoved(first, second, {3.5, -2.25});
}

TEST(PointTracker, FollowsThroughAChangeOfExposure) {
  PointTracker tracker(SomeCamera(), TrackerOptions());
  const TrackedImage first = tracker.Track(Blobs(0, 0, 1), 0, Eigen::Matrix3d::Identity());
  const TrackedImage second = tracker.Track(Blobs(2, 1, 0.6), 1, Eigen::Matrix3d::Identity());
  ExpectMoved(first, second, {2, 1});
}

/// A lamp on one side, and a sensor that reaches its white: `strength` grey levels at its middle.
cv::Mat LitFromTheSide(const cv::Mat& image, double strength) {
  cv::Mat lit = image.clone();
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double distance = std::hypot(x - 40, y - 60) / 150;
      const double light = 1 + strength / 100 * std::exp(-distance * distance);
      lit.at<unsigned char>(y, x) =
          cv::saturate_cast<unsigned char>(light * image.at<unsigned char>(y, x) + 0.1 * strength);
    }
  }
  return lit;
}

TEST(PointTracker, ALampIsSwitchedOn) {
  PointTracker tracker(SomeCamera(), TrackerOptions());
  TrackedImage last = tracker.Track(Blobs(0, 0, 0.5), 0, Eigen::Matrix3d::Identity());
  const TrackedImage first = last;
  for (int k = 1; k <= 6; ++k) {  // on from the third image, off again with the sixth
    cv::Mat image = Blobs(1.5 * k, 0.5 * k, 0.5);
    if (k >= 3 && k < 6) image = LitFromTheSide(image, 90);
    const TrackedImage next = tracker.Track(image, k, Eigen::Matrix3d::Identity());
    SCOPED_TRACE(k);
    ExpectMoved(last, next, {1.5, 0.5});
    EXPECT_EQ(tracker.light_jump() > 1, k == 3);
    EXPECT_EQ(tracker.light_jump() < 1, k == 6);
    last = next;
  }
  // Most of what was seen before the lamp is still followed after it.
  const auto from = ById(first), to = ById(last);
  std::size_t followed = 0;
  for (const auto& [id, pixel] : from) followed += to.count(id);
  EXPECT_GT(followed, from.size() / 2);
}

TEST(PointTracker, TheGyroShowsWhereALargeMotionEnds) {
  TrackerOptions options;
  options.levels = 1;  // reaches some 20 px on its own
  PointTracker tracker(SomeCamera(), options);
  const TrackedImage first = tracker.Track(Blobs(0, 0, 1), 0, Eigen::Matrix3d::Identity());
  // A turn of the camera to the left moves the middle of the image by 40 px to the right.
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(-std::atan(40.0 / 250), Eigen::Vector3d::UnitY()).toRotationMatrix();
  const TrackedImage second = tracker.Track(Blobs(40, 0, 1), 1, turn);
  const auto from = ById(first), to = ById(second);
  int followed = 0;
  for (const auto& [id, pixel] : from) {
    const auto found = to.find(id);
    followed += found != to.end() && std::abs(found->second.x() - pixel.x() - 40) < 0.5 ? 1 : 0;
  }
  EXPECT_GT(followed, 20);
}

TEST(PointTracker, FindsNothingInTheDarkAndNewPointsAfterwards) {
  PointTracker tracker(SomeCamera(), TrackerOptions());
  const TrackedImage first = tracker.Track(Blobs(0, 0, 1), 0, Eigen::Matrix3d::Identity());
  const cv::Mat dark(240, 320, CV_8UC1, cv::Scalar(0));
  EXPECT_TRUE(tracker.Track(dark, 1, Eigen::Matrix3d::Identity()).points.empty());
  const TrackedImage third = tracker.Track(Blobs(0, 0, 1), 2, Eigen::Matrix3d::Identity());
  EXPECT_GT(third.points.size(), 30u);
  EXPECT_GT(third.points.front().id, first.points.back().id);
}

}  // namespace
}  // namespace plumbline
