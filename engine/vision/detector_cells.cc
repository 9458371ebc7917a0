// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/detector_cells.h"

#include <algorithm>
#include <map>

#include "engine/base/check.h"

namespace plumbline {
namespace {

class DenseDetections : public FrameDetections {
 public:
  std::span<const Detection> proposals() const override { return proposals_; }
  void ScoreBoxes(std::string_view category, std::span<const Box2> boxes,
                  std::span<float> scores) const override {
    PLB_CHECK(boxes.size() == scores.size());
    const auto found = dense_.find(category);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      scores[i] = found == dense_.end() ? 0.0f : found->second.Score(boxes[i]);
    }
  }

  std::vector<Detection> proposals_;
  std::map<std::string, ScoredBoxes, std::less<>> dense_;
};

}  // namespace

Cells::Cells(const NetworkSidecar& sidecar, const FittedImage& fitted,
             const DetectorOptions& options)
    : sidecar_(sidecar), fitted_(fitted), options_(options), dense_(sidecar.categories.size()) {}

void Cells::ScoreAll(const float* scores, std::ptrdiff_t step, float objectness) {
  const int categories = static_cast<int>(sidecar_.categories.size());
  for (int category = 0; category < categories; ++category)
    Score(category, objectness * scores[category * step]);
}

void Cells::End(float x0, float y0, float x1, float y1) {
  if (scored_.empty()) return;
  const auto width = static_cast<float>(fitted_.original.width);
  const auto height = static_cast<float>(fitted_.original.height);
  // Image points are pixel centres at integers, so the image spans [-0.5, width - 0.5].
  const Box2 box{InImage(x0, sidecar_.width, fitted_.scale_x, fitted_.offset_x, width),
                 InImage(y0, sidecar_.height, fitted_.scale_y, fitted_.offset_y, height),
                 InImage(x1, sidecar_.width, fitted_.scale_x, fitted_.offset_x, width),
                 InImage(y1, sidecar_.height, fitted_.scale_y, fitted_.offset_y, height)};
  auto best = scored_.front();
  for (const auto& entry : scored_) {
    dense_[static_cast<std::size_t>(entry.first)].Add(box, entry.second);
    if (entry.second > best.second) best = entry;
  }
  scored_.clear();
  if (!box.empty() && best.second >= options_.min_score)
    proposals_.push_back(
        {box, sidecar_.categories[static_cast<std::size_t>(best.first)], best.second});
}

void Cells::EndCorners(float x0, float y0, float x1, float y1) {
  const auto width = static_cast<float>(sidecar_.width);
  const auto height = static_cast<float>(sidecar_.height);
  End(x0 / width, y0 / height, x1 / width, y1 / height);
}

void Cells::EndCentred(float x, float y, float width, float height) {
  EndCorners(x - width / 2, y - height / 2, x + width / 2, y + height / 2);
}

std::unique_ptr<const FrameDetections> Cells::Finish() {
  auto result = std::make_unique<DenseDetections>();
  result->proposals_ = SuppressNonMaxima(std::move(proposals_), options_.nms_iou);
  for (std::size_t i = 0; i < dense_.size(); ++i) {
    dense_[i].Sort();
    result->dense_.emplace(sidecar_.categories[i], std::move(dense_[i]));
  }
  return result;
}

float Cells::InImage(float share, int input, double scale, double offset, float size) const {
  const float at = sidecar_.fit == ImageFit::kStretch
                       ? share * size
                       : static_cast<float>((share * static_cast<float>(input) - offset) / scale);
  return std::clamp(at, 0.0f, size) - 0.5f;
}

std::vector<Level> LevelsOf(const NetworkSidecar& sidecar) {
  std::vector<Level> levels;
  for (const int stride : sidecar.strides)
    levels.push_back(
        {stride, (sidecar.width + stride - 1) / stride, (sidecar.height + stride - 1) / stride});
  return levels;
}

int CellsOf(const std::vector<Level>& levels) {
  int cells = 0;
  for (const Level& level : levels) cells += level.cells();
  return cells;
}

std::vector<int> ShapeOf(const cv::Mat& tensor) {
  std::vector<int> shape(tensor.size.p, tensor.size.p + tensor.dims);
  while (shape.size() > 2 && shape.front() == 1) shape.erase(shape.begin());
  return shape;
}

cv::Mat AsTable(const cv::Mat& tensor) {
  const int columns = tensor.size[tensor.dims - 1];
  return {static_cast<int>(tensor.total()) / columns, columns, CV_32FC1,
          const_cast<float*>(tensor.ptr<float>())};
}

}  // namespace plumbline
