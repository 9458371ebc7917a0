// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/vision/edge_detector.h"

namespace plumbline {

/// A pixel on the crest of the image's gradient, and what is known there about whether it is an
/// edge.
struct EdgeCandidate {
  static constexpr int kNumFeatures = 8;
  std::int32_t x = 0, y = 0;
  float normal_x = 1, normal_y = 0;  ///< Unit; normal_x >= 0.
  /// Gradients along the normal, in log2 of grey levels per pixel of the level: brightness at
  /// levels 0, 1 and 2 (full, half and quarter size), colour at 1 and 2; gradients around, in any
  /// direction (`around`: within about 5 px, `far`: 12 px); the share of those around that agrees
  /// with the normal, in [0, 1].
  std::array<float, kNumFeatures>
      features{};  // brightness0 brightness1 colour1 brightness2 colour2 around agree far
  float log_odds =
      0;  ///< That the annotators of BSDS500 call it a boundary (docs/algorithms/edges.md).
};

/// Finds crests: local maxima, along the normal, of a structure tensor summed over three scales and
/// the channels of YCrCb. Keeps its buffers from image to image.
class EdgeCandidateFinder {
 public:
  /// @param image  CV_8UC3 BGR. The candidates are valid until the next call.
  const std::vector<EdgeCandidate>& Find(const cv::Mat& image);
  /// CV_32FC1, at least as large as the image: the map whose crests these are.
  const cv::Mat& crest() const { return crest_; }

 private:
  /// One smaller level: d/dx and d/dy of Y, Cr and Cb and what else is asked for at a pixel,
  /// packed.
  struct Level {
    cv::Mat bgr, ycc, planes[3], dx[3], dy[3];
    cv::Mat packed;  ///< CV_32FC(n)
    cv::Mat tensor;  ///< CV_32FC3
  };
  void MakePyramid(const cv::Mat& image);
  void MakeLevel(const float (&weights)[2], int channels, Level& level);
  void FindCrests(int y, int columns);

  cv::Mat padded_, gray_;
  cv::Mat dx_, dy_;  ///< CV_16SC1, full size, brightness.
  Level half_, quarter_;
  cv::Mat around_, far_, enlarged_, trace_;
  cv::Mat crest_;  ///< CV_32FC1, full size: trace of the whole structure tensor.
  std::vector<float> difference_, twice_, marks_;  ///< Of one row; see MarkCrests.
  std::vector<EdgeCandidate> candidates_;
};

/// Edges from image gradients alone, without an image network.
std::unique_ptr<EdgeDetector> CreateGradientEdgeDetector();

}  // namespace plumbline
