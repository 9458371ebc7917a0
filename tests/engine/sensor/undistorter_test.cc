// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/undistorter.h"

#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/random.h"
#include "engine/sensor/distorted_camera.h"

namespace plumbline {
namespace {

Camera KitchenLens(std::vector<double> distortion) {
  Camera camera;
  camera.model = CameraModel::kRadialTangential;
  camera.pinhole = {640, 480, 511, 512, 320.5, 240.5};
  camera.distortion = std::move(distortion);
  return camera;
}

Camera Fisheye() {
  Camera camera;
  camera.model = CameraModel::kEquidistant;
  camera.pinhole = {512, 512, 190.978, 190.973, 254.932, 256.897};
  camera.distortion = {0.0034824, 0.00071503, -0.0020532, 0.00020294};
  return camera;
}

Eigen::Vector2d UndistortPixel(const Camera& camera, const Eigen::Vector2d& pixel) {
  const cv::Point2d result = UndistortPixels(camera, {{pixel.x(), pixel.y()}}).at(0);
  return {result.x, result.y};
}

cv::Mat Noise(cv::Size size) {
  Random random({.seed = 5});
  cv::Mat image(size, CV_8UC3);
  for (std::size_t i = 0; i < image.total() * 3; ++i)
    image.data[i] = static_cast<unsigned char>(random.Index(256));
  cv::GaussianBlur(image, image, {}, 3);
  return image;
}

TEST(Undistorter, LeavesPinholeImagesAlone) {
  Camera camera;
  camera.pinhole = {4, 3, 2, 2, 1.5, 1};
  const cv::Mat image(3, 4, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(Undistorter(camera).Undistort(image).data, image.data);
  EXPECT_EQ(UndistortPixel(camera, {2, 1}), Eigen::Vector2d(2, 1));
}

TEST(Undistorter, InvertsTheClosedFormOfTheLens) {
  const Camera camera = KitchenLens({-0.28, 0.07, 0.0002, 1.8e-5, -0.01});
  const auto [k1, k2, p1, p2, k3] = std::array{-0.28, 0.07, 0.0002, 1.8e-5, -0.01};
  for (double v = 40; v < 480; v += 80) {
    for (double u = 40; u < 640; u += 80) {
      const Eigen::Vector2d ideal = camera.pinhole.Bearing({u, v});
      const double x = ideal.x(), y = ideal.y(), r2 = ideal.squaredNorm();
      const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
      const Eigen::Vector3d bent(x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
                                 y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y, 1);
      EXPECT_LT(
          (UndistortPixel(camera, camera.pinhole.Project(bent)) - Eigen::Vector2d(u, v)).norm(),
          0.05)
          << u << " " << v;
    }
  }
}

TEST(Undistorter, MovesImageAndPixelAlike) {
  const Camera camera = KitchenLens({-0.28, 0.07, 0.0002, 1.8e-5});
  const Undistorter undistorter(camera);
  // A soft blob so that its centre is known below a pixel.
  cv::Mat image(480, 640, CV_8UC1);
  const Eigen::Vector2d blob(100, 80);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      image.at<unsigned char>(y, x) = cv::saturate_cast<unsigned char>(
          250 * std::exp(-(Eigen::Vector2d(x, y) - blob).squaredNorm() / (2 * 5.0 * 5.0)));
    }
  }
  const cv::Mat result = undistorter.Undistort(image);
  double sum = 0;
  Eigen::Vector2d centre(0, 0);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      sum += result.at<unsigned char>(y, x);
      centre += result.at<unsigned char>(y, x) * Eigen::Vector2d(x, y);
    }
  }
  // The blob is a little stretched, which moves its centre of mass by a fraction of a pixel.
  EXPECT_LT((centre / sum - UndistortPixel(camera, blob)).norm(), 0.5);
  EXPECT_GT((UndistortPixel(camera, blob) - blob).norm(), 3);
}

TEST(Undistorter, GivesTheSameImageAsOpenCvForTheLensesThatWereReadBefore) {
  const Camera camera = KitchenLens({-0.28, 0.07, 0.0002, 1.8e-5, -0.01});
  const PinholeCamera& c = camera.pinhole;
  const cv::Matx33d k(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  const cv::Mat image = Noise({c.width, c.height});
  cv::Mat map1, map2, expected;
  cv::initUndistortRectifyMap(k, camera.distortion, cv::noArray(), k, image.size(), CV_16SC2, map1,
                              map2);
  cv::remap(image, expected, map1, map2, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  EXPECT_EQ(cv::norm(Undistorter(camera).Undistort(image), expected, cv::NORM_INF), 0);
}

TEST(Undistorter, GivesTheSameFisheyeImageAsOpenCv) {
  const Camera camera = Fisheye();
  const PinholeCamera& c = camera.pinhole;
  const cv::Matx33d k(c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1);
  const cv::Mat image = Noise({c.width, c.height});
  cv::Mat map1, map2, expected;
  cv::fisheye::initUndistortRectifyMap(k, camera.distortion, cv::Matx33d::eye(), k, image.size(),
                                       CV_16SC2, map1, map2);
  cv::remap(image, expected, map1, map2, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  // Both round the map to 1/32 pixel; a tie may fall either way.
  EXPECT_LE(cv::norm(Undistorter(camera).Undistort(image), expected, cv::NORM_INF), 2);
}

TEST(UndistortPixels, FindsThePinholePixelOfEveryModelAndNoneBehindTheCamera) {
  for (const CameraModel model : {CameraModel::kEquidistant, CameraModel::kFov}) {
    Camera camera = Fisheye();
    camera.model = model;
    if (model == CameraModel::kFov) camera.distortion = {0.93};
    const Eigen::Vector3d ray(0.4, -0.7, 0.5);
    const auto recorded = DistortedCamera(camera).Project(ray);
    ASSERT_TRUE(recorded);
    EXPECT_LT((UndistortPixel(camera, recorded->pixel) - camera.pinhole.Project(ray)).norm(), 1e-8);
    EXPECT_TRUE(std::isnan(UndistortPixel(camera, {-5000, 200}).x()));
  }
  const auto behind = DistortedCamera(Fisheye()).Project({1, 0, -0.2});
  ASSERT_TRUE(behind);
  EXPECT_TRUE(std::isnan(UndistortPixel(Fisheye(), behind->pixel).x()));
}

TEST(Undistorter, KeepsDepthApartAtItsEdges) {
  const Camera camera = Fisheye();
  cv::Mat depth(512, 512, CV_16UC1, cv::Scalar(1000));
  depth.colRange(256, 512) = 3000;
  const cv::Mat result = Undistorter(camera).UndistortNearest(depth);
  cv::Mat known = (result == 1000) | (result == 3000);
  EXPECT_EQ(cv::countNonZero(known), 512 * 512);
}

}  // namespace
}  // namespace plumbline
