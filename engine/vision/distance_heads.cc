// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/distance_heads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace plumbline {
namespace {

constexpr int kLeastBins = 2;  // in tensors that may also hold scores

/// Where the numbers of a level's cells lie.
struct Part {
  const float *scores = nullptr, *logits = nullptr;
  std::ptrdiff_t score_step = 0, logit_step = 0;
  int bins = 0;
};

/// The levels' parts of tensors that hold all cells, level after level.
std::vector<Part> Parts(Part all, const std::vector<Level>& levels) {
  std::vector<Part> parts;
  for (const Level& level : levels) {
    parts.push_back(all);
    all.scores += level.cells() * all.score_step;
    all.logits += level.cells() * all.logit_step;
  }
  return parts;
}

std::vector<Part> PartsOfCellsAndSides(const std::vector<cv::Mat>& outputs, int categories,
                                       const std::vector<Level>& levels) {
  const cv::Mat& sides = outputs[outputs[0].dims == 4 ? 0 : 1];
  const cv::Mat& scores = outputs[outputs[0].dims == 4 ? 1 : 0];
  if (sides.size[1] != CellsOf(levels) || scores.size[2] != categories) return {};
  const int bins = sides.size[3];
  return Parts({scores.ptr<float>(), sides.ptr<float>(), categories, 4 * bins, bins}, levels);
}

std::vector<Part> PartsOfTable(const cv::Mat& output, int categories,
                               const std::vector<Level>& levels) {
  const std::vector<int> shape = ShapeOf(output);
  if (shape.size() != 2 || shape[0] != CellsOf(levels)) return {};
  const int columns = shape[1], rest = columns - categories;
  if (rest < 4 * kLeastBins || rest % 4 != 0) return {};
  const auto* first = output.ptr<float>();
  return Parts({first, first + categories, columns, columns, rest / 4}, levels);
}

std::vector<Part> PartsOfLevels(const std::vector<cv::Mat>& outputs, int categories,
                                const std::vector<Level>& levels) {
  std::vector<Part> parts(levels.size());
  for (const cv::Mat& output : outputs) {
    const std::vector<int> shape = ShapeOf(output);
    if (shape.size() != 2) return {};
    const auto level = std::find_if(levels.begin(), levels.end(),
                                    [&](const Level& l) { return l.cells() == shape[0]; });
    if (level == levels.end()) return {};
    Part& part = parts[static_cast<std::size_t>(level - levels.begin())];
    if (shape[1] == categories && part.scores == nullptr) {
      part.scores = output.ptr<float>();
      part.score_step = shape[1];
    } else if (shape[1] % 4 == 0 && shape[1] >= 4 * kLeastBins && part.logits == nullptr) {
      part.logits = output.ptr<float>();
      part.logit_step = shape[1];
      part.bins = shape[1] / 4;
    } else {
      return {};
    }
  }
  for (const Part& part : parts)
    if (part.scores == nullptr || part.logits == nullptr) return {};
  return parts;
}

/// The mean of a distribution over 0, 1, .. given as logits; of a single number, the number.
float Distance(const float* logits, int count) {
  if (count == 1) return logits[0];
  const float highest = *std::max_element(logits, logits + count);
  float sum = 0, weighted = 0;
  for (int i = 0; i < count; ++i) {
    const float weight = std::exp(logits[i] - highest);
    sum += weight;
    weighted += weight * static_cast<float>(i);
  }
  return weighted / sum;
}

void DecodeLevel(const Part& part, const Level& level, int categories, float point_in_cell,
                 Cells& cells) {
  const auto stride = static_cast<float>(level.stride);
  for (int cell = 0; cell < level.cells(); ++cell) {
    const float* scores = part.scores + cell * part.score_step;
    if (!(*std::max_element(scores, scores + categories) >= kLeastScore)) continue;
    cells.ScoreAll(scores, 1, 1);
    const float* logits = part.logits + cell * part.logit_step;
    std::array<float, 4> away{};
    for (float& side : away) {
      side = stride * Distance(logits, part.bins);
      logits += part.bins;
    }
    const float x = (static_cast<float>(cell % level.columns) + point_in_cell) * stride;
    const float y = (static_cast<float>(cell / level.columns) + point_in_cell) * stride;
    cells.EndCorners(x - away[0], y - away[1], x + away[2], y + away[3]);
  }
}

}  // namespace

bool AreCellsAndSides(const std::vector<cv::Mat>& outputs) {
  if (outputs.size() != 2 || outputs[0].dims + outputs[1].dims != 3 + 4) return false;
  const cv::Mat& sides = outputs[outputs[0].dims == 4 ? 0 : 1];
  const cv::Mat& scores = outputs[outputs[0].dims == 4 ? 1 : 0];
  return sides.dims == 4 && sides.size[0] == 1 && sides.size[2] == 4 && scores.size[0] == 1 &&
         scores.size[1] == sides.size[1];
}

bool DecodeDistances(const std::vector<cv::Mat>& outputs, const NetworkSidecar& sidecar,
                     float point_in_cell, Cells& cells) {
  const int categories = static_cast<int>(sidecar.categories.size());
  const std::vector<Level> levels = LevelsOf(sidecar);
  const std::vector<Part> parts =
      AreCellsAndSides(outputs) ? PartsOfCellsAndSides(outputs, categories, levels)
      : outputs.size() == 1     ? PartsOfTable(outputs.front(), categories, levels)
                                : PartsOfLevels(outputs, categories, levels);
  if (parts.empty()) return false;
  for (std::size_t i = 0; i < levels.size(); ++i)
    DecodeLevel(parts[i], levels[i], categories, point_in_cell, cells);
  return true;
}

}  // namespace plumbline
