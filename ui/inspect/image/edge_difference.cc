// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/image/edge_difference.h"

#include <algorithm>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

constexpr int kWeakest = 40;  ///< Edges of a lower probability (of 255) do not count.
constexpr double kNear_px = 5;

cv::Mat DistanceTo(const cv::Mat& mask) {
  cv::Mat inverse, distance;
  cv::bitwise_not(mask, inverse);
  cv::distanceTransform(inverse, distance, cv::DIST_L2, 3);
  return distance;
}

}  // namespace

cv::Mat EdgeDifferencePicture(const MapSnapshot& snapshot, const std::vector<ObjectId>& left_out) {
  const cv::Mat& probability = snapshot.edge_probability;
  if (probability.empty()) return {};
  const cv::Mat edges = probability >= kWeakest;
  cv::Mat contour = cv::Mat::zeros(probability.size(), CV_8U);
  for (const OutlineView& outline : snapshot.outlines) {
    if (std::find(left_out.begin(), left_out.end(), outline.object) != left_out.end()) continue;
    for (const auto& points : outline.contours) {
      std::vector<cv::Point> line;
      for (const Eigen::Vector2f& p : points) line.emplace_back(cvRound(p.x()), cvRound(p.y()));
      cv::polylines(contour, line, true, 255, 2);
    }
  }
  // The border of the image makes contours, but no edges.
  cv::rectangle(contour, {0, 0}, {contour.cols - 1, contour.rows - 1}, 0, 5);
  cv::Mat picture(probability.size(), CV_8UC3, cv::Scalar(15, 12, 10));
  picture.setTo(cv::Scalar(112, 104, 96), edges);
  if (cv::countNonZero(contour) == 0) return picture;
  picture.setTo(cv::Scalar(120, 210, 100), edges & (DistanceTo(contour) <= kNear_px));
  if (cv::countNonZero(edges) > 0)
    picture.setTo(cv::Scalar(84, 92, 240), contour & (DistanceTo(edges) > kNear_px));
  return picture;
}

}  // namespace plumbline
