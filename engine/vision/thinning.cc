// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/thinning.h"

#include <algorithm>
#include <array>

#include <opencv2/imgproc.hpp>

#include "engine/base/check.h"

namespace plumbline {
namespace {

constexpr double kRidgeSigmaPx = 0.7;
constexpr double kOrientationSigmaPx = 2.0;

/// For each pattern of the eight neighbours (bit i: neighbour i, anticlockwise from the right):
/// whether the pixel in the middle can go without parting what it joins and without shortening a
/// line.
std::array<bool, 256> SparePatterns() {
  std::array<bool, 256> spare{};
  for (int pattern = 0; pattern < 256; ++pattern) {
    const auto on = [&](int i) { return (pattern >> (i & 7) & 1) != 0; };
    int neighbours = 0, parts = 0, sides = 0;
    for (int i = 0; i < 8; ++i) neighbours += on(i);
    for (int i = 0; i < 8; i += 2) {
      sides += on(i);
      parts += !on(i) && (on(i + 1) || on(i + 2));  // Yokoi's count of 8-connected parts
    }
    spare[pattern] = neighbours >= 2 && sides >= 1 && sides < 4 && parts == 1;
  }
  // Two neighbours side by side are one end of a line, not a step of it.
  for (int i = 0; i < 8; ++i) spare[1 << i | 1 << ((i + 1) & 7)] = false;
  return spare;
}

}  // namespace

float CalibrationCurve::operator()(float raw) const {
  if (points_.empty()) return raw;
  const auto after =
      std::upper_bound(points_.begin(), points_.end(), raw,
                       [](float value, const auto& point) { return value < point.first; });
  if (after == points_.begin()) return points_.front().second;
  if (after == points_.end()) return points_.back().second;
  const auto& [x0, y0] = *std::prev(after);
  const auto& [x1, y1] = *after;
  return y0 + (y1 - y0) * (raw - x0) / (x1 - x0);
}

void RemoveSpareCorners(const cv::Mat& strength, cv::Mat& map) {
  PLB_CHECK(map.type() == CV_8UC1 && strength.type() == CV_32FC1 && strength.size() == map.size());
  PLB_CHECK(map.isContinuous());
  static const std::array<bool, 256> spare = SparePatterns();
  const int step = map.cols;
  const int around[8] = {1, 1 - step, -step, -1 - step, -1, step - 1, step, step + 1};
  auto* pixels = map.ptr<std::uint8_t>();
  std::vector<cv::Point> set;
  for (int y = 1; y + 1 < map.rows; ++y) {
    for (int x = 1; x + 1 < map.cols; ++x) {
      if (pixels[y * step + x] != 0) set.emplace_back(x, y);
    }
  }
  const auto stride = static_cast<std::ptrdiff_t>(strength.step1());
  for (const bool weaker_only : {true, false}) {
    for (const cv::Point& point : set) {
      auto* here = pixels + point.y * step + point.x;
      int pattern = 0;
      for (int i = 0; i < 8; ++i) pattern |= (here[around[i]] != 0) << i;
      // Without branches: which pixels go is not predictable.
      const auto* own = strength.ptr<float>(point.y) + point.x;
      const bool weaker = ((here[1] != 0) & (own[1] > own[0])) |
                          ((here[-1] != 0) & (own[-1] > own[0])) |
                          ((here[step] != 0) & (own[stride] > own[0])) |
                          ((here[-step] != 0) & (own[-stride] > own[0]));
      const bool gone = spare[pattern] & (weaker | !weaker_only);
      *here = gone ? 0 : *here;
    }
  }
}

EdgeMap ThinRidges(const cv::Mat& soft, float least, const CalibrationCurve& calibrate) {
  PLB_CHECK(soft.type() == CV_32FC1);
  EdgeMap edges{cv::Mat::zeros(soft.size(), CV_8UC1), cv::Mat::zeros(soft.size(), CV_8UC1)};
  cv::Mat ridge, smooth, xx, xy, yy;
  cv::GaussianBlur(soft, ridge, {}, kRidgeSigmaPx, kRidgeSigmaPx, cv::BORDER_REFLECT_101);
  cv::GaussianBlur(soft, smooth, {}, kOrientationSigmaPx, kOrientationSigmaPx,
                   cv::BORDER_REFLECT_101);
  cv::Sobel(smooth, xx, CV_32F, 2, 0, 5);
  cv::Sobel(smooth, xy, CV_32F, 1, 1, 5);
  cv::Sobel(smooth, yy, CV_32F, 0, 2, 5);
  for (int y = 1; y + 2 < soft.rows; ++y) {
    for (int x = 1; x + 2 < soft.cols; ++x) {
      const float here = ridge.at<float>(y, x);
      if (!(soft.at<float>(y, x) >= least)) continue;
      if (!(xx.at<float>(y, x) + yy.at<float>(y, x) < 0))
        continue;  // a foot of a ridge, not its crest
      const float difference = xx.at<float>(y, x) - yy.at<float>(y, x);
      // Twice the angle of the larger eigenvalue; the ridge's normal has the smaller, most negative
      // one.
      const float normal = 0.5f * std::atan2(-2 * xy.at<float>(y, x), -difference);
      const float nx = std::cos(normal), ny = std::sin(normal);
      const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
      // On a plateau only one side may tie, so that one pixel of it stays.
      if (1.003f * here <
          std::max(Interpolate(ridge, fx + nx, fy + ny), Interpolate(ridge, fx - nx, fy - ny)))
        continue;
      edges.probability.at<std::uint8_t>(y, x) = ProbabilityToByte(calibrate(here));
      edges.angle.at<std::uint8_t>(y, x) = AngleToByte(normal);
    }
  }
  RemoveSpareCorners(ridge, edges.probability);
  edges.angle.setTo(0, edges.probability == 0);
  return edges;
}

}  // namespace plumbline
