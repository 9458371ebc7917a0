// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include <opencv2/core.hpp>

#include "engine/base/random.h"
#include "engine/dataset/sequence.h"

namespace plumbline {

/// A straight edge through the middle of a square image: the points p with (p - middle) . normal =
/// offset.
struct StraightEdge {
  double normal_rad = 0;  ///< [0, pi)
  double offset_px = 0;
  int side_px = 120;

  double Distance(double x, double y) const {
    const double middle = 0.5 * (side_px - 1);
    return (x - middle) * std::cos(normal_rad) + (y - middle) * std::sin(normal_rad) - offset_px;
  }
};

/// Dark on one side, bright on the other, with a blur of one pixel and Gaussian noise [grey
/// levels].
inline cv::Mat StepImage(const StraightEdge& edge, double contrast, double noise) {
  Random random({.seed = 5});
  cv::Mat image(edge.side_px, edge.side_px, CV_8UC3);
  for (int y = 0; y < edge.side_px; ++y) {
    for (int x = 0; x < edge.side_px; ++x) {
      const double level =
          100 + contrast * (0.5 + 0.5 * std::erf(edge.Distance(x, y) / std::numbers::sqrt2));
      for (int c = 0; c < 3; ++c) {
        image.at<cv::Vec3b>(y, x)[c] =
            cv::saturate_cast<unsigned char>(level + noise * random.Gaussian());
      }
    }
  }
  return image;
}

/// How well an edge map shows one straight edge, in the disc that touches the image's sides less a
/// margin.
struct LineQuality {
  double worst_angle_deg = 0;  ///< Of pixels on the line.
  double mean_angle_deg = 0;
  double pixels_per_step = 0;  ///< 1: an unbroken line of one pixel.
  double mean_offset_px = 0;   ///< Distance of its pixels from the true edge, with its sign.
  int strays = 0;              ///< Pixels away from the line, of at least `least_stray`.
};

inline LineQuality MeasureLine(const EdgeMap& edges, const StraightEdge& edge,
                               int least_stray = 1) {
  LineQuality quality;
  int on_line = 0;
  const double middle = 0.5 * (edge.side_px - 1), radius = middle - 8;
  for (int y = 0; y < edge.side_px; ++y) {
    for (int x = 0; x < edge.side_px; ++x) {
      if (edges.probability.at<unsigned char>(y, x) == 0 ||
          std::hypot(x - middle, y - middle) > radius)
        continue;
      const double distance = edge.Distance(x, y);
      if (std::abs(distance) > 2) {
        quality.strays += edges.probability.at<unsigned char>(y, x) >= least_stray;
        continue;
      }
      const double angle = edges.angle.at<unsigned char>(y, x) * std::numbers::pi / 256;
      const double error = std::abs(std::remainder(angle - edge.normal_rad, std::numbers::pi)) *
                           180 / std::numbers::pi;
      quality.worst_angle_deg = std::max(quality.worst_angle_deg, error);
      quality.mean_angle_deg += error;
      quality.mean_offset_px += distance;
      ++on_line;
    }
  }
  const double length = 2 * std::sqrt(radius * radius - edge.offset_px * edge.offset_px);
  const double steps =
      length * std::max(std::abs(std::cos(edge.normal_rad)), std::abs(std::sin(edge.normal_rad)));
  quality.pixels_per_step = on_line / steps;
  quality.mean_angle_deg /= std::max(1, on_line);
  quality.mean_offset_px /= std::max(1, on_line);
  return quality;
}

}  // namespace plumbline
