// SPDX-License-Identifier: Apache-2.0
#include "tests/support/tiny_network.h"

#include <cmath>
#include <fstream>
#include <vector>

#include "engine/base/check.h"
#include "tests/support/tiny_graph.h"

namespace plumbline {
namespace {

constexpr float kHalfBox = 8;  // [px of the input]
constexpr float kPlace = 32;   // of boxes that do not follow their cell [px of the input]
constexpr int kBins = 8;       // of distances, as GFL heads have them

/// `front`, then a score for each category.
std::vector<float> WithScores(std::vector<float> front, const TinyNetwork& network) {
  for (int i = 0; i < network.categories; ++i)
    front.push_back(i == network.best_category ? network.score : 0);
  return front;
}

/// Logits over whole strides whose mean is kHalfBox, for the four sides.
std::vector<float> Distances(int stride) {
  // Between two bins; where the box is under a stride, bins 0 and 1.
  const float strides = kHalfBox / static_cast<float>(stride);
  const int lower = static_cast<int>(strides);
  const float upper_share = strides - static_cast<float>(lower);
  std::vector<float> logits;
  for (int side = 0; side < 4; ++side) {
    for (int bin = 0; bin < kBins; ++bin) {
      const float share = bin == lower ? 1 - upper_share : bin == lower + 1 ? upper_share : 0;
      logits.push_back(share > 0 ? std::log(share) : -50);
    }
  }
  return logits;
}

}  // namespace

void WriteTinyNetwork(const std::filesystem::path& file, const TinyNetwork& network) {
  TinyGraph graph(network);
  const float box = 2 * kHalfBox;
  const std::vector<int> three = {8, 16, 32}, four = {8, 16, 32, 64};
  std::vector<std::string> parts;
  switch (network.kind) {
    case NetworkKind::kEdge:
      graph.Output(graph.Grid(1, {network.score}));
      break;
    case NetworkKind::kFastestDet: {
      // Half the size that a sigmoid gives, as a share of the image.
      const auto logit = [](float share) { return std::log(share / (1 - share)); };
      graph.Output(graph.Grid(16, WithScores({1, std::atanh(0.5f), std::atanh(0.5f),
                                              logit(box / static_cast<float>(network.width)),
                                              logit(box / static_cast<float>(network.height))},
                                             network)));
      break;
    }
    case NetworkKind::kYolox:
      for (const int stride : three) {
        const auto values = WithScores({0.5f, 0.5f, std::log(box / static_cast<float>(stride)),
                                        std::log(box / static_cast<float>(stride)), 1},
                                       network);
        parts.push_back(graph.Flat(graph.Grid(stride, values), static_cast<int>(values.size())));
      }
      graph.Output(graph.Turned(graph.Joined(parts)));
      break;
    case NetworkKind::kYolov5:
    case NetworkKind::kYolov8: {
      const bool five = network.kind == NetworkKind::kYolov5;
      std::vector<float> values = {kPlace, kPlace, box, box};
      if (five) values.push_back(1);
      values = WithScores(values, network);
      const std::vector<float> masks(static_cast<std::size_t>(network.masks), 1);
      values.insert(values.end(), masks.begin(), masks.end());
      for (int anchor = 0; anchor < (five ? 3 : 1); ++anchor)
        for (const int stride : three)
          parts.push_back(graph.Flat(graph.Grid(stride, values), static_cast<int>(values.size())));
      const std::string joined = graph.Joined(parts);
      graph.Output(five ? graph.Turned(joined) : joined);
      if (network.masks > 0) graph.Output(graph.Grid(4, masks));
      break;
    }
    case NetworkKind::kYolov10:
      graph.Output(graph.Turned(graph.Flat(
          graph.Grid(16,
                     {kPlace - kHalfBox, kPlace - kHalfBox, kPlace + kHalfBox, kPlace + kHalfBox,
                      network.score, static_cast<float>(network.best_category)}),
          6)));
      break;
    case NetworkKind::kPicodet:
      for (const int stride : four) {
        graph.Output(graph.Turned(
            graph.Flat(graph.Grid(stride, WithScores({}, network)), network.categories)));
        graph.Output(graph.Turned(graph.Flat(graph.Grid(stride, Distances(stride)), 4 * kBins)));
      }
      break;
    case NetworkKind::kNanodet:
      for (const int stride : four) {
        std::vector<float> values = WithScores({}, network);
        for (const float logit : Distances(stride)) values.push_back(logit);
        parts.push_back(graph.Flat(graph.Grid(stride, values), static_cast<int>(values.size())));
      }
      graph.Output(graph.Turned(graph.Joined(parts)));
      break;
    case NetworkKind::kSsd: {
      const auto width = static_cast<float>(network.width),
                 height = static_cast<float>(network.height);
      graph.Output(graph.Turned(graph.Flat(graph.Grid(16, WithScores({1 - network.score}, network)),
                                           1 + network.categories)));
      graph.Output(graph.Turned(
          graph.Flat(graph.Grid(16, {(kPlace - kHalfBox) / width, (kPlace - kHalfBox) / height,
                                     (kPlace + kHalfBox) / width, (kPlace + kHalfBox) / height}),
                     4)));
      break;
    }
    case NetworkKind::kTwoStage:
      PLB_CHECK(false);
  }
  graph.Write(file);
}

void WriteTinyTwoStage(const std::filesystem::path& file, int head_categories) {
  const TinyNetwork tiny;
  TinyGraph trunk(tiny);
  // The feature, the objectness of one anchor, its four deltas.
  trunk.Output(trunk.Means(trunk.image(), 3, 8, {1, 20, 0, 0, 0, 0}, {0, -10, 0, 0, 0, 0}));
  trunk.Write(file);
  TinyGraph head(tiny, {32, 1, 7, 7});
  const auto classes = static_cast<std::size_t>(1 + head_categories);
  std::vector<float> weights(5 * classes), bias(5 * classes);
  for (std::size_t category = 1; category < classes; ++category) bias[category] = -30;
  weights[2] = 20;
  bias[2] = -10;
  head.Output(head.Flattened(head.Means(head.image(), 1, 7, weights, bias)));
  head.Write(std::filesystem::path(file).replace_extension(".head.onnx"));
  std::ofstream(std::filesystem::path(file).replace_extension(".json")) << R"({
    "kind": "two_stage", "width": 64, "height": 64, "resize": "letterbox", "strides": [8],
    "scale": 0.00392156862745098, "categories": ["chair", "couch"],
    "anchors": [{"sizes": [16], "ratios": [1]}],
    "rpn": {"before_nms": 50, "after_nms": 20, "nms_iou": 0.7, "min_score": 0.5,
            "weights": [1, 1, 1, 1]},
    "crops": {"size": 7, "sampling": 2, "levels": 1, "canonical_scale": 224, "canonical_level": 4},
    "boxes": {"weights": [10, 10, 5, 5], "most": 100}})";
}

}  // namespace plumbline
