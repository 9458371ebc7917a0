// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/detector_heads.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/base/check.h"
#include "engine/vision/proposals.h"

namespace plumbline {
namespace {

/// Cells that score less than this say nothing about a category: with score * IoU they can add no
/// more.
constexpr float kLeastScore = 0.01f;

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

/// Collects the cells of one image.
class Cells {
 public:
  Cells(const NetworkSidecar& sidecar, const FittedImage& fitted, const DetectorOptions& options)
      : sidecar_(sidecar), fitted_(fitted), options_(options), dense_(sidecar.categories.size()) {}

  /// What the next cell scores for a category; those under kLeastScore and no numbers do not count.
  void Score(int category, float score) {
    if (score >= kLeastScore) scored_.emplace_back(category, std::min(1.0f, score));
  }
  /// Ends a cell: its box, in shares of the network's input.
  void End(float x0, float y0, float x1, float y1) {
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
      dense_[entry.first].Add(box, entry.second);
      if (entry.second > best.second) best = entry;
    }
    scored_.clear();
    if (!box.empty() && best.second >= options_.min_score)
      proposals_.push_back({box, sidecar_.categories[best.first], best.second});
  }

  std::unique_ptr<const FrameDetections> Finish() {
    auto result = std::make_unique<DenseDetections>();
    result->proposals_ = SuppressNonMaxima(std::move(proposals_), options_.nms_iou);
    for (std::size_t i = 0; i < dense_.size(); ++i) {
      dense_[i].Sort();
      result->dense_.emplace(sidecar_.categories[i], std::move(dense_[i]));
    }
    return result;
  }

 private:
  float InImage(float share, int input, double scale, double offset, float size) const {
    const float at = sidecar_.fit == ImageFit::kStretch
                         ? share * size
                         : static_cast<float>((share * input - offset) / scale);
    return std::clamp(at, 0.0f, size) - 0.5f;
  }

  const NetworkSidecar& sidecar_;
  const FittedImage& fitted_;
  const DetectorOptions& options_;
  std::vector<ScoredBoxes> dense_;
  std::vector<Detection> proposals_;
  std::vector<std::pair<int, float>> scored_;
};

float Sigmoid(float x) { return 1 / (1 + std::exp(-x)); }

/// The lengths of a tensor without those of 1 in front.
std::vector<int> ShapeOf(const cv::Mat& tensor) {
  std::vector<int> shape(tensor.size.p, tensor.size.p + tensor.dims);
  while (shape.size() > 2 && shape.front() == 1) shape.erase(shape.begin());
  return shape;
}

/// A tensor as a matrix, its last axis the columns.
cv::Mat AsTable(const cv::Mat& tensor) {
  const int columns = tensor.size[tensor.dims - 1];
  return {static_cast<int>(tensor.total()) / columns, columns, CV_32FC1,
          const_cast<float*>(tensor.ptr<float>())};
}

/// A level of a pyramid of cells.
struct Level {
  int stride, columns, rows;
  int cells() const { return columns * rows; }
};
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

/// Each decoder is false if the outputs are not of its shapes.
using Outputs = std::vector<cv::Mat>;

/// [1, 5 + categories, rows, columns]: objectness, box, categories.
bool DecodeFastestDet(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  constexpr float kObjectnessPower = 0.6f, kClassPower = 0.4f;
  const int categories = static_cast<int>(sidecar.categories.size());
  const Level level = LevelsOf(sidecar).front();
  const cv::Mat& output = outputs.front();
  if (outputs.size() != 1 || output.dims != 4 || output.size[1] != 5 + categories ||
      output.size[2] != sidecar.height / level.stride ||
      output.size[3] != sidecar.width / level.stride)
    return false;
  const int columns = output.size[3], count = output.size[2] * columns;
  const auto raw = [&](int channel, int cell) { return output.ptr<float>(0, channel)[cell]; };
  for (int cell = 0; cell < count; ++cell) {
    const float object_part = std::pow(std::clamp(raw(0, cell), 0.0f, 1.0f), kObjectnessPower);
    if (!(object_part >= kLeastScore)) continue;
    // score >= kLeastScore, solved for the class probability: few cells need the power.
    const float least = std::pow(kLeastScore / object_part, 1 / kClassPower);
    for (int category = 0; category < categories; ++category) {
      const float probability = raw(5 + category, cell);
      if (probability >= least)
        cells.Score(category,
                    std::max(kLeastScore, object_part * std::pow(probability, kClassPower)));
    }
    const float x = (static_cast<float>(cell % columns) + std::tanh(raw(1, cell))) /
                    static_cast<float>(columns);
    const float y = (static_cast<float>(cell / columns) + std::tanh(raw(2, cell))) /
                    static_cast<float>(output.size[2]);
    const float half_width = Sigmoid(raw(3, cell)) / 2, half_height = Sigmoid(raw(4, cell)) / 2;
    cells.End(x - half_width, y - half_height, x + half_width, y + half_height);
  }
  return true;
}

void ScoreAll(const float* scores, int step, int categories, float objectness, Cells& cells) {
  for (int category = 0; category < categories; ++category)
    cells.Score(category, objectness * scores[static_cast<std::ptrdiff_t>(category) * step]);
}

/// Ends a cell whose box is given by centre and size, in pixels of the input.
void EndCentred(float x, float y, float width, float height, const NetworkSidecar& sidecar,
                Cells& cells) {
  const auto w = static_cast<float>(sidecar.width), h = static_cast<float>(sidecar.height);
  cells.End((x - width / 2) / w, (y - height / 2) / h, (x + width / 2) / w, (y + height / 2) / h);
}

/// [1, cells, 5 + categories], level by level: centre in its cell, log of the size in strides,
/// objectness, categories.
bool DecodeYolox(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  const int categories = static_cast<int>(sidecar.categories.size());
  const std::vector<Level> levels = LevelsOf(sidecar);
  if (outputs.size() != 1 ||
      ShapeOf(outputs.front()) != std::vector{CellsOf(levels), 5 + categories})
    return false;
  const cv::Mat table = AsTable(outputs.front());
  int row = 0;
  for (const Level& level : levels) {
    const auto stride = static_cast<float>(level.stride);
    for (int cell = 0; cell < level.cells(); ++cell, ++row) {
      const auto* v = table.ptr<float>(row);
      if (!(v[4] >= kLeastScore)) continue;
      ScoreAll(v + 5, 1, categories, v[4], cells);
      EndCentred((v[0] + static_cast<float>(cell % level.columns)) * stride,
                 (v[1] + static_cast<float>(cell / level.columns)) * stride,
                 std::exp(v[2]) * stride, std::exp(v[3]) * stride, sidecar, cells);
    }
  }
  return true;
}

/// [1, boxes, 5 + categories or more]: centre and size in pixels of the input, objectness,
/// categories.
bool DecodeYolov5(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  const int categories = static_cast<int>(sidecar.categories.size());
  const std::vector<int> shape = ShapeOf(outputs.front());
  if (shape.size() != 2 || shape[1] < 5 + categories) return false;
  const cv::Mat table = AsTable(outputs.front());
  for (int row = 0; row < table.rows; ++row) {
    const auto* v = table.ptr<float>(row);
    if (!(v[4] >= kLeastScore)) continue;
    ScoreAll(v + 5, 1, categories, v[4], cells);
    EndCentred(v[0], v[1], v[2], v[3], sidecar, cells);
  }
  return true;
}

/// [1, 4 + categories or more, boxes]: centre and size in pixels of the input, categories.
bool DecodeYolov8(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  const int categories = static_cast<int>(sidecar.categories.size());
  const std::vector<int> shape = ShapeOf(outputs.front());
  if (shape.size() != 2 || shape[0] < 4 + categories || shape[1] < shape[0]) return false;
  const cv::Mat table = AsTable(outputs.front());
  for (int box = 0; box < table.cols; ++box) {
    const auto value = [&](int row) { return table.at<float>(row, box); };
    ScoreAll(table.ptr<float>(4) + box, table.cols, categories, 1, cells);
    EndCentred(value(0), value(1), value(2), value(3), sidecar, cells);
  }
  return true;
}

/// The mean of a distribution over 0, 1, .. given as logits.
float MeanOfLogits(const float* logits, int count) {
  const float highest = *std::max_element(logits, logits + count);
  float sum = 0, weighted = 0;
  for (int i = 0; i < count; ++i) {
    const float weight = std::exp(logits[i] - highest);
    sum += weight;
    weighted += weight * static_cast<float>(i);
  }
  return weighted / sum;
}

/// Generalised focal loss: scores per category, and the distance of each side from the cell's
/// point as logits over whole strides. For each level two tensors, or both for all cells in one
/// table: [1, cells, categories] and [1, cells, 4 * bins], told apart by their last axis.
bool DecodeDistances(const Outputs& outputs, const NetworkSidecar& sidecar, float point_in_cell,
                     Cells& cells) {
  const int categories = static_cast<int>(sidecar.categories.size());
  const std::vector<Level> levels = LevelsOf(sidecar);
  struct Part {
    const float *scores = nullptr, *logits = nullptr;
    int score_step = 0, logit_step = 0, bins = 0;
  };
  std::vector<Part> parts(levels.size());
  if (outputs.size() == 1) {
    const std::vector<int> shape = ShapeOf(outputs.front());
    if (shape.size() != 2 || shape[0] != CellsOf(levels)) return false;
    const int rest = shape[1] - categories;
    if (rest < 8 || rest % 4 != 0) return false;
    int row = 0;
    for (std::size_t i = 0; i < levels.size(); ++i) {
      const float* first =
          outputs.front().ptr<float>() + static_cast<std::ptrdiff_t>(row) * shape[1];
      parts[i] = {first, first + categories, shape[1], shape[1], rest / 4};
      row += levels[i].cells();
    }
  } else {
    for (const cv::Mat& output : outputs) {
      const std::vector<int> shape = ShapeOf(output);
      if (shape.size() != 2) return false;
      const auto level = std::find_if(levels.begin(), levels.end(),
                                      [&](const Level& l) { return l.cells() == shape[0]; });
      if (level == levels.end()) return false;
      Part& part = parts[static_cast<std::size_t>(level - levels.begin())];
      if (shape[1] == categories && part.scores == nullptr) {
        part.scores = output.ptr<float>();
        part.score_step = shape[1];
      } else if (shape[1] % 4 == 0 && shape[1] >= 8 && part.logits == nullptr) {
        part.logits = output.ptr<float>();
        part.logit_step = shape[1];
        part.bins = shape[1] / 4;
      } else {
        return false;
      }
    }
  }
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const Part& part = parts[i];
    if (part.scores == nullptr || part.logits == nullptr) return false;
    const auto stride = static_cast<float>(levels[i].stride);
    const auto w = static_cast<float>(sidecar.width), h = static_cast<float>(sidecar.height);
    for (int cell = 0; cell < levels[i].cells(); ++cell) {
      const float* scores = part.scores + static_cast<std::ptrdiff_t>(cell) * part.score_step;
      if (!(*std::max_element(scores, scores + categories) >= kLeastScore)) continue;
      ScoreAll(scores, 1, categories, 1, cells);
      const float* logits = part.logits + static_cast<std::ptrdiff_t>(cell) * part.logit_step;
      float away[4];
      for (int side = 0; side < 4; ++side)
        away[side] = stride * MeanOfLogits(logits + static_cast<std::ptrdiff_t>(side) * part.bins,
                                           part.bins);
      const float x = (static_cast<float>(cell % levels[i].columns) + point_in_cell) * stride;
      const float y = (static_cast<float>(cell / levels[i].columns) + point_in_cell) * stride;
      cells.End((x - away[0]) / w, (y - away[1]) / h, (x + away[2]) / w, (y + away[3]) / h);
    }
  }
  return true;
}

/// Whether every row of a table does.
bool SumToOne(const cv::Mat& output) {
  cv::Mat sums;
  cv::reduce(AsTable(output), sums, 1, cv::REDUCE_SUM);
  constexpr double kRounding = 1e-2;
  return cv::norm(sums, cv::Mat::ones(sums.size(), CV_32F), cv::NORM_INF) < kRounding;
}

/// [1, boxes, 1 + categories] (the first is the background) and [1, boxes, 4] (corners, in shares);
/// or [1, 1, found, 7] (image, label, score, corners), where label 0 is the background.
bool DecodeSsd(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  const int categories = static_cast<int>(sidecar.categories.size());
  if (outputs.size() == 1) {
    const std::vector<int> shape = ShapeOf(outputs.front());
    if (shape.size() != 2 || shape[1] != 7) return false;
    const cv::Mat table = AsTable(outputs.front());
    for (int row = 0; row < table.rows; ++row) {
      const auto* v = table.ptr<float>(row);
      if (!(v[1] >= 1 && v[1] <= static_cast<float>(categories))) continue;
      cells.Score(static_cast<int>(v[1]) - 1, v[2]);
      cells.End(v[3], v[4], v[5], v[6]);
    }
    return true;
  }
  const cv::Mat *scores = nullptr, *corners = nullptr;
  for (const cv::Mat& output : outputs) {
    const std::vector<int> shape = ShapeOf(output);
    if (shape.size() != 2) continue;
    // With three categories both have four columns; what a softmax gives sums to one.
    if (shape[1] == 1 + categories && (shape[1] != 4 || SumToOne(output))) {
      scores = &output;
    } else if (shape[1] == 4) {
      corners = &output;
    }
  }
  if (scores == nullptr || corners == nullptr) return false;
  const cv::Mat score_table = AsTable(*scores), corner_table = AsTable(*corners);
  if (score_table.rows != corner_table.rows) return false;
  for (int row = 0; row < score_table.rows; ++row) {
    ScoreAll(score_table.ptr<float>(row) + 1, 1, categories, 1, cells);
    const auto* v = corner_table.ptr<float>(row);
    cells.End(v[0], v[1], v[2], v[3]);
  }
  return true;
}

bool Decode(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  switch (sidecar.kind) {
    case NetworkKind::kFastestDet:
      return DecodeFastestDet(outputs, sidecar, cells);
    case NetworkKind::kYolox:
      return DecodeYolox(outputs, sidecar, cells);
    case NetworkKind::kYolov5:
      return DecodeYolov5(outputs, sidecar, cells);
    case NetworkKind::kYolov8:
      return DecodeYolov8(outputs, sidecar, cells);
    case NetworkKind::kPicodet:
      return DecodeDistances(outputs, sidecar, 0.5f, cells);
    case NetworkKind::kNanodet:
      return DecodeDistances(outputs, sidecar, 0, cells);
    case NetworkKind::kSsd:
      return DecodeSsd(outputs, sidecar, cells);
    case NetworkKind::kEdge:
    case NetworkKind::kTwoStage:
      return false;
  }
  return false;
}

}  // namespace

Result<std::unique_ptr<const FrameDetections>> DecodeDetections(const std::vector<cv::Mat>& outputs,
                                                                const NetworkSidecar& sidecar,
                                                                const FittedImage& fitted,
                                                                const DetectorOptions& options) {
  bool floats = !outputs.empty();
  for (const cv::Mat& output : outputs)
    floats &= output.type() == CV_32FC1 && output.isContinuous() && !output.empty();
  Cells cells(sidecar, fitted, options);
  if (floats && Decode(outputs, sidecar, cells)) return cells.Finish();
  return Error{ErrorCode::kInvalidInput, "gives outputs of " + ShapesText(outputs) +
                                             ", which its sidecar (kind " +
                                             std::string(NameOf(sidecar.kind)) + ", " +
                                             std::to_string(sidecar.categories.size()) +
                                             " categories, " + std::to_string(sidecar.width) + "x" +
                                             std::to_string(sidecar.height) + ") does not explain"};
}

}  // namespace plumbline
