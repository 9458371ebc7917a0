// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/undistort.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "engine/sensor/undistorter.h"

namespace plumbline {

EdgeMap UndistortEdges(const Camera& camera, const EdgeMap& recorded) {
  if (camera.distortion.empty() || recorded.empty()) return recorded;
  // Each edge pixel with its neighbour one pixel along the edge: the pair turns as the edge does.
  std::vector<cv::Point> pixels;
  std::vector<cv::Point2d> points;
  for (int y = 0; y < recorded.probability.rows; ++y) {
    for (int x = 0; x < recorded.probability.cols; ++x) {
      if (recorded.probability.at<std::uint8_t>(y, x) == 0) continue;
      const double normal = recorded.angle.at<std::uint8_t>(y, x) * std::numbers::pi / 256;
      pixels.emplace_back(x, y);
      points.emplace_back(x, y);
      points.emplace_back(x - std::sin(normal), y + std::cos(normal));
    }
  }
  EdgeMap result{cv::Mat::zeros(recorded.probability.size(), CV_8UC1),
                 cv::Mat::zeros(recorded.angle.size(), CV_8UC1)};
  if (pixels.empty()) return result;
  points = UndistortPixels(camera, std::move(points));
  const cv::Rect image({}, result.probability.size());
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const cv::Point2d along = points[2 * i + 1] - points[2 * i];
    if (!std::isfinite(along.x) || !std::isfinite(along.y) || !(cv::norm(points[2 * i]) < 1e6))
      continue;
    const cv::Point target(cvRound(points[2 * i].x), cvRound(points[2 * i].y));
    if (!image.contains(target)) continue;
    const auto probability = recorded.probability.at<std::uint8_t>(pixels[i]);
    if (probability <= result.probability.at<std::uint8_t>(target)) continue;
    const double normal = std::atan2(-along.x, along.y);
    result.probability.at<std::uint8_t>(target) = probability;
    result.angle.at<std::uint8_t>(target) = static_cast<std::uint8_t>(
        static_cast<int>(std::lround(normal * 256 / std::numbers::pi)) & 255);
  }
  return result;
}

Box2 UndistortBox(const Camera& camera, const Box2& recorded) {
  if (camera.distortion.empty()) return recorded;
  constexpr int kSteps = 8;
  std::vector<cv::Point2d> outline;
  for (int i = 0; i <= kSteps; ++i) {
    const double x = recorded.x0 + (recorded.x1 - recorded.x0) * i / kSteps;
    const double y = recorded.y0 + (recorded.y1 - recorded.y0) * i / kSteps;
    outline.insert(outline.end(),
                   {{x, recorded.y0}, {x, recorded.y1}, {recorded.x0, y}, {recorded.x1, y}});
  }
  outline = UndistortPixels(camera, std::move(outline));
  Box2 box{1e9f, 1e9f, -1e9f, -1e9f};
  for (const cv::Point2d& point : outline) {
    if (!std::isfinite(point.x)) continue;  // beside what the pinhole camera can see
    box.x0 = std::min(box.x0, static_cast<float>(point.x));
    box.y0 = std::min(box.y0, static_cast<float>(point.y));
    box.x1 = std::max(box.x1, static_cast<float>(point.x));
    box.y1 = std::max(box.y1, static_cast<float>(point.y));
  }
  return box.x0 <= box.x1 ? box : Box2{};
}

}  // namespace plumbline
