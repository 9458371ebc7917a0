// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/undistort.h"

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "engine/sensor/undistorter.h"

namespace plumbline {
namespace {

Camera Distorted() {
  Camera camera;
  camera.model = CameraModel::kRadialTangential;
  camera.pinhole = {320, 240, 250, 250, 159.5, 119.5};
  camera.distortion = {-0.28, 0.07, 0.0002, 1.8e-5};
  return camera;
}

Eigen::Vector2d Undistorted(const Camera& camera, const Eigen::Vector2d& pixel) {
  const cv::Point2d result = UndistortPixels(camera, {{pixel.x(), pixel.y()}}).at(0);
  return {result.x, result.y};
}

TEST(UndistortEdges, LeavesPinholeEdgesAlone) {
  Camera camera = Distorted();
  camera.distortion.clear();
  const EdgeMap edges{cv::Mat::ones(240, 320, CV_8UC1), cv::Mat::zeros(240, 320, CV_8UC1)};
  EXPECT_EQ(UndistortEdges(camera, edges).probability.data, edges.probability.data);
}

TEST(UndistortEdges, MovesPixelsAndTurnsNormals) {
  const Camera camera = Distorted();
  EdgeMap edges{cv::Mat::zeros(240, 320, CV_8UC1), cv::Mat::zeros(240, 320, CV_8UC1)};
  edges.probability.at<unsigned char>(40, 60) = 99;
  edges.angle.at<unsigned char>(40, 60) = 64;  // 45 degrees
  const EdgeMap moved = UndistortEdges(camera, edges);
  const Eigen::Vector2d expected = Undistorted(camera, {60, 40});
  const cv::Point pixel(cvRound(expected.x()), cvRound(expected.y()));
  EXPECT_EQ(moved.probability.at<unsigned char>(pixel), 99);
  EXPECT_EQ(cv::countNonZero(moved.probability), 1);
  // Along the edge, 1 px at a time, the undistorted points turn as the normal says.
  const double a = 64 * M_PI / 256;
  const Eigen::Vector2d along =
      Undistorted(camera, {60 - 2 * std::sin(a), 40 + 2 * std::cos(a)}) - expected;
  const double normal = moved.angle.at<unsigned char>(pixel) * M_PI / 256;
  EXPECT_NEAR(along.normalized().dot(Eigen::Vector2d(std::cos(normal), std::sin(normal))), 0, 0.02);
}

TEST(UndistortBox, BoundsTheUndistortedOutline) {
  const Camera camera = Distorted();
  const Box2 box = UndistortBox(camera, {20, 30, 300, 220});
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(20, 30), {300, 30}, {20, 220}, {300, 220}}) {
    const Eigen::Vector2d point = Undistorted(camera, corner);
    EXPECT_GE(point.x(), box.x0 - 1e-3);
    EXPECT_LE(point.x(), box.x1 + 1e-3);
    EXPECT_GE(point.y(), box.y0 - 1e-3);
    EXPECT_LE(point.y(), box.y1 + 1e-3);
  }
  EXPECT_LT(box.x0, 10);
}

TEST(UndistortBox, OfAFisheyeHoldsWhatThePinholeSees) {
  Camera camera;
  camera.model = CameraModel::kFov;
  camera.pinhole = {640, 480, 257.7, 258.2, 327.7, 229.1};
  camera.distortion = {0.93};
  const Box2 box = UndistortBox(camera, {300, 200, 340, 240});
  EXPECT_GT(box.width(), 35);
  EXPECT_LT(box.width(), 45);
  EXPECT_TRUE(UndistortBox(camera, {-900, 200, -800, 240}).empty());
}

}  // namespace
}  // namespace plumbline
