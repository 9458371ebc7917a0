// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/detector_heads.h"

#include <algorithm>
#include <cmath>

#include "engine/vision/detector_cells.h"
#include "engine/vision/distance_heads.h"

namespace plumbline {
namespace {

float Sigmoid(float x) { return 1 / (1 + std::exp(-x)); }

/// Each decoder is false if the outputs are not of its shapes.
using Outputs = std::vector<cv::Mat>;

/// The output that has the boxes: networks that also give masks have a second, of four axes.
const cv::Mat& BoxesOf(const Outputs& outputs) {
  return outputs[outputs.size() == 2 && outputs[0].dims == 4 ? 1 : 0];
}

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
      cells.ScoreAll(v + 5, 1, v[4]);
      cells.EndCentred((v[0] + static_cast<float>(cell % level.columns)) * stride,
                       (v[1] + static_cast<float>(cell / level.columns)) * stride,
                       std::exp(v[2]) * stride, std::exp(v[3]) * stride);
    }
  }
  return true;
}

/// [1, boxes, 5 + categories or more]: centre and size in pixels of the input, objectness,
/// categories.
bool DecodeYolov5(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  const int categories = static_cast<int>(sidecar.categories.size());
  const std::vector<int> shape = ShapeOf(BoxesOf(outputs));
  if (shape.size() != 2 || shape[1] < 5 + categories) return false;
  const cv::Mat table = AsTable(BoxesOf(outputs));
  for (int row = 0; row < table.rows; ++row) {
    const auto* v = table.ptr<float>(row);
    if (!(v[4] >= kLeastScore)) continue;
    cells.ScoreAll(v + 5, 1, v[4]);
    cells.EndCentred(v[0], v[1], v[2], v[3]);
  }
  return true;
}

/// [1, 4 + categories or more, boxes]: centre and size in pixels of the input, categories. Or not
/// decoded yet.
bool DecodeYolov8(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  constexpr float kMiddle = 0.5f;
  if (AreCellsAndSides(outputs)) return DecodeDistances(outputs, sidecar, kMiddle, cells);
  const int categories = static_cast<int>(sidecar.categories.size());
  const std::vector<int> shape = ShapeOf(BoxesOf(outputs));
  if (shape.size() != 2 || shape[0] < 4 + categories || shape[1] < shape[0]) return false;
  const cv::Mat table = AsTable(BoxesOf(outputs));
  for (int box = 0; box < table.cols; ++box) {
    const auto value = [&](int row) { return table.at<float>(row, box); };
    cells.ScoreAll(table.ptr<float>(4) + box, table.cols, 1);
    cells.EndCentred(value(0), value(1), value(2), value(3));
  }
  return true;
}

/// [1, found, 6 or more]: corners in pixels of the input, score, category. Or not decoded yet.
bool DecodeYolov10(const Outputs& outputs, const NetworkSidecar& sidecar, Cells& cells) {
  if (AreCellsAndSides(outputs)) return DecodeYolov8(outputs, sidecar, cells);
  const auto categories = static_cast<float>(sidecar.categories.size());
  const std::vector<int> shape = ShapeOf(BoxesOf(outputs));
  if (shape.size() != 2 || shape[1] < 6) return false;
  const cv::Mat table = AsTable(BoxesOf(outputs));
  for (int row = 0; row < table.rows; ++row) {
    const auto* v = table.ptr<float>(row);
    if (!(v[5] >= 0 && v[5] < categories)) continue;
    cells.Score(static_cast<int>(v[5]), v[4]);
    cells.EndCorners(v[0], v[1], v[2], v[3]);
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
    cells.ScoreAll(score_table.ptr<float>(row) + 1, 1, 1);
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
    case NetworkKind::kYolov10:
      return DecodeYolov10(outputs, sidecar, cells);
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
