// SPDX-License-Identifier: Apache-2.0
#include "engine/sensor/undistorter.h"

#include <limits>

#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/sensor/distorted_camera.h"

namespace plumbline {
namespace {

cv::Matx33d Intrinsics(const PinholeCamera& c) { return {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1}; }

/// Where each pixel of the pinhole camera lies in the recorded image.
cv::Mat RecordedPixels(const Camera& camera) {
  const DistortedCamera distorted(camera);
  const PinholeCamera& pinhole = camera.pinhole;
  cv::Mat map(pinhole.height, pinhole.width, CV_32FC2, cv::Scalar(-1, -1));
  for (int v = 0; v < map.rows; ++v) {
    for (int u = 0; u < map.cols; ++u) {
      const Eigen::Vector2d bearing = pinhole.Bearing(Eigen::Vector2d(u, v));
      const auto seen = distorted.Project({bearing.x(), bearing.y(), 1});
      if (!seen) continue;
      map.at<cv::Vec2f>(v, u) = {static_cast<float>(seen->pixel.x()),
                                 static_cast<float>(seen->pixel.y())};
    }
  }
  return map;
}

cv::Mat Remap(const cv::Mat& image, const cv::Mat& map1, const cv::Mat& map2, int interpolation) {
  if (map1.empty()) return image;
  cv::Mat result;
  cv::remap(image, result, map1, map2, interpolation, cv::BORDER_CONSTANT);
  return result;
}

}  // namespace

Undistorter::Undistorter(const Camera& camera) {
  switch (camera.model) {
    case CameraModel::kPinhole:
      return;
    case CameraModel::kRadialTangential: {
      const cv::Matx33d intrinsics = Intrinsics(camera.pinhole);
      cv::initUndistortRectifyMap(intrinsics, camera.distortion, cv::noArray(), intrinsics,
                                  {camera.pinhole.width, camera.pinhole.height}, CV_16SC2, map1_,
                                  map2_);
      return;
    }
    case CameraModel::kEquidistant:
    case CameraModel::kFov:
      cv::convertMaps(RecordedPixels(camera), cv::noArray(), map1_, map2_, CV_16SC2);
      return;
  }
}

cv::Mat Undistorter::Undistort(const cv::Mat& image) const {
  return Remap(image, map1_, map2_, cv::INTER_LINEAR);
}

cv::Mat Undistorter::UndistortNearest(const cv::Mat& image) const {
  return Remap(image, map1_, map2_, cv::INTER_NEAREST);
}

std::vector<cv::Point2d> UndistortPixels(const Camera& camera, std::vector<cv::Point2d> pixels) {
  if (camera.model == CameraModel::kPinhole || pixels.empty()) return pixels;
  if (camera.model == CameraModel::kRadialTangential) {
    const cv::Matx33d intrinsics = Intrinsics(camera.pinhole);
    std::vector<cv::Point2d> result;
    cv::undistortPoints(pixels, result, intrinsics, camera.distortion, cv::noArray(), intrinsics);
    return result;
  }
  const DistortedCamera distorted(camera);
  for (cv::Point2d& pixel : pixels) {
    const auto ray = distorted.Unproject({pixel.x, pixel.y});
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    pixel = {kNone, kNone};
    if (!ray || ray->z() <= 1e-6) continue;
    const Eigen::Vector2d ideal = camera.pinhole.Project(*ray);
    pixel = {ideal.x(), ideal.y()};
  }
  return pixels;
}

}  // namespace plumbline
