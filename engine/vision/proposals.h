// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "engine/dataset/sequence.h"

namespace plumbline {

/// Keeps the best of the boxes of one category that overlap by more than `max_iou`; by falling
/// score (ties: by category, then from left to right), so that the order never depends on that of
/// the input.
std::vector<Detection> SuppressNonMaxima(std::vector<Detection> detections, float max_iou);

/// Scored boxes of one category, by falling score, ready for many questions.
class ScoredBoxes {
 public:
  void Add(const Box2& box, float score);
  /// Must be called after the last Add.
  void Sort();
  /// max over the boxes of score * IoU(box, query): in [0, 1], continuous in the query.
  float Score(const Box2& query) const;

 private:
  struct Entry {
    Box2 box;
    float score;
  };
  std::vector<Entry> entries_;
  /// The same after Sort, one array per number and filled up to a multiple of four.
  std::vector<float> x0_, y0_, x1_, y1_, area_, score_;
};

}  // namespace plumbline
