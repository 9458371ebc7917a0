// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/dataset/sequence.h"

namespace plumbline {

/// A raw score in [0, 1] to a probability: linear between the points, constant beyond the first and
/// the last.
class CalibrationCurve {
 public:
  /// @param points  (raw, probability), raw strictly rising; the identity where there are none.
  explicit CalibrationCurve(std::vector<std::pair<float, float>> points)
      : points_(std::move(points)) {}
  float operator()(float raw) const;

 private:
  std::vector<std::pair<float, float>> points_;
};

/// The direction of a normal, in [-pi, 2 pi], as edge maps store it: in [0, pi) times 256 / pi,
/// rounded.
inline std::uint8_t AngleToByte(float angle_rad) {
  return static_cast<std::uint8_t>(
      static_cast<int>(angle_rad * static_cast<float>(256 / std::numbers::pi) + 256.5f) & 255);
}

/// A probability as edge maps store it.
inline std::uint8_t ProbabilityToByte(float probability) {
  return static_cast<std::uint8_t>(std::clamp(probability, 0.0f, 1.0f) * 255 + 0.5f);
}

/// The value of a CV_32FC1 map between its pixels, bilinear; (x, y) must lie in [0, columns - 1) x
/// [0, rows - 1).
inline float Interpolate(const cv::Mat& map, float x, float y) {
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const auto* upper = map.ptr<float>(y0) + x0;
  const auto* lower = map.ptr<float>(y0 + 1) + x0;
  return (upper[0] * (1 - fx) + upper[1] * fx) * (1 - fy) +
         (lower[0] * (1 - fx) + lower[1] * fx) * fy;
}

/// Thins a soft edge map, whose edges are ridges a few pixels wide, to lines of one pixel. The
/// normal is the direction of strongest curvature (Hessian at sigma 2); a pixel stays if no point
/// one pixel along the normal is higher.
/// @param soft    CV_32FC1 in [0, 1].
/// @param least   Ridges lower than this are left out.
EdgeMap ThinRidges(const cv::Mat& soft, float least, const CalibrationCurve& calibrate);

/// Takes away pixels of a CV_8UC1 map that are not needed to keep its lines connected (steps of
/// staircases, second rows), so that lines are one pixel wide; those that are weaker by `strength`
/// (CV_32FC1) than a neighbour go first. Ends of lines stay.
void RemoveSpareCorners(const cv::Mat& strength, cv::Mat& map);

}  // namespace plumbline
