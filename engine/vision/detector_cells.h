// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/vision/detector.h"
#include "engine/vision/network.h"
#include "engine/vision/proposals.h"

namespace plumbline {

/// Cells that score less than this say nothing about a category: with score * IoU they can add no
/// more.
constexpr float kLeastScore = 0.01f;

/// Collects the cells of one image that a detector gives.
class Cells {
 public:
  Cells(const NetworkSidecar& sidecar, const FittedImage& fitted, const DetectorOptions& options);

  /// What the next cell scores for a category; those under kLeastScore and no numbers do not count.
  void Score(int category, float score) {
    if (score >= kLeastScore) scored_.emplace_back(category, std::min(1.0f, score));
  }
  /// The same for all categories, `step` numbers apart, times `objectness`.
  void ScoreAll(const float* scores, std::ptrdiff_t step, float objectness);
  /// Ends a cell: its box, in shares of the network's input.
  void End(float x0, float y0, float x1, float y1);
  /// The same in pixels of the input, by corners, and by centre and size.
  void EndCorners(float x0, float y0, float x1, float y1);
  void EndCentred(float x, float y, float width, float height);

  std::unique_ptr<const FrameDetections> Finish();

 private:
  float InImage(float share, int input, double scale, double offset, float size) const;

  const NetworkSidecar& sidecar_;
  const FittedImage& fitted_;
  const DetectorOptions& options_;
  std::vector<ScoredBoxes> dense_;
  std::vector<Detection> proposals_;
  std::vector<std::pair<int, float>> scored_;
};

/// A level of a pyramid of cells.
struct Level {
  int stride, columns, rows;
  int cells() const { return columns * rows; }
};
std::vector<Level> LevelsOf(const NetworkSidecar& sidecar);
int CellsOf(const std::vector<Level>& levels);

/// The lengths of a tensor without those of 1 in front, but two at least.
std::vector<int> ShapeOf(const cv::Mat& tensor);

/// A tensor as a matrix, its last axis the columns; shares its numbers.
cv::Mat AsTable(const cv::Mat& tensor);

}  // namespace plumbline
