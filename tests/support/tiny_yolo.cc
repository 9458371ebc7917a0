// SPDX-License-Identifier: Apache-2.0
#include "tests/support/tiny_yolo.h"

#include <cmath>
#include <string>
#include <vector>

#include "tests/support/tiny_graph.h"

namespace plumbline {
namespace {

constexpr float kReach = 8;    // [px of the input]
constexpr float kNever = -50;  // as a logit

class YoloWriter {
 public:
  explicit YoloWriter(const TinyYolo& yolo)
      : yolo_(yolo),
        strides_(yolo.small_levels ? std::vector{4, 8, 16, 32} : std::vector{8, 16, 32}),
        graph_({.width = yolo.width, .height = yolo.height, .free_size = yolo.free_size}) {
    for (const int stride : strides_) cells_ += yolo.width / stride * (yolo.height / stride);
  }

  void Write(const std::filesystem::path& file) {
    std::string sides, scores;
    Last(sides, scores);
    scores = graph_.Node("Sigmoid", {scores});
    std::string output = graph_.Joined({Boxes(Distances(sides)), scores}, 1);
    if (yolo_.masks > 0) output = graph_.Joined({output, Masks()}, 1);
    graph_.Output(yolo_.chosen ? Chosen(output) : output);
    if (yolo_.masks > 0)
      graph_.Output(graph_.Grid(4, std::vector<float>(static_cast<std::size_t>(yolo_.masks))));
    graph_.Write(file);
  }

 private:
  /// The last convolutions, [1, 4 * bins, cells] and [1, categories, cells].
  void Last(std::string& sides, std::string& scores) {
    std::vector<std::string> all, all_sides, all_scores;
    for (const int stride : strides_) {
      const std::string side = graph_.Grid(stride, Sides(stride));
      const std::string score = graph_.Grid(stride, Scores());
      if (yolo_.by_level)
        all.push_back(Flat(graph_.Joined({side, score}, 1), 4 * yolo_.bins + yolo_.categories));
      all_sides.push_back(side);
      all_scores.push_back(score);
    }
    if (yolo_.by_level) {
      sides = graph_.Node("Split", {graph_.Joined(all)}, 2);
      scores = graph_.Other(1);
      graph_.SetInt("axis", 1);
      graph_.SetInts("split", {4 * yolo_.bins, yolo_.categories});
      return;
    }
    for (std::string& side : all_sides) side = Flat(side, 4 * yolo_.bins);
    for (std::string& score : all_scores) score = Flat(score, yolo_.categories);
    sides = graph_.Joined(all_sides);
    scores = graph_.Joined(all_scores);
  }

  /// As torch writes `view`, with the image's number computed where sizes are open.
  std::string Flat(const std::string& grid, int channels) {
    if (!yolo_.free_size) return graph_.Flat(grid, channels);
    const std::string number =
        graph_.Node("Gather", {graph_.Node("Shape", {grid}), graph_.Whole(0)});
    const std::string row = graph_.Node("Unsqueeze", {number});
    graph_.SetInts("axes", {0});
    return graph_.Node("Reshape", {grid, graph_.Joined({row, graph_.Wholes({channels, -1})}, 0)});
  }

  /// [1, 4 * bins, cells] to [1, 4, cells].
  std::string Distances(const std::string& sides) {
    if (yolo_.bins == 1) return yolo_.exponential ? graph_.Node("Exp", {sides}) : sides;
    const std::string table =
        graph_.Node("Reshape", {sides, graph_.Wholes({1, 4, yolo_.bins, -1})});
    const std::string turned = graph_.Node("Transpose", {table});
    graph_.SetInts("perm", {0, 2, 1, 3});
    const std::string shares = graph_.Node("Softmax", {turned});
    graph_.SetInt("axis", 1);
    std::vector<float> numbers;
    for (int bin = 0; bin < yolo_.bins; ++bin) numbers.push_back(static_cast<float>(bin));
    const std::string mean =
        graph_.Node("Conv", {shares, graph_.Floats({1, yolo_.bins, 1, 1}, numbers)});
    graph_.SetInts("kernel_shape", {1, 1});
    return graph_.Node("Reshape", {mean, graph_.Wholes({1, 4, -1})});
  }

  /// Distances from the cells' middles as centre and size in pixels.
  std::string Boxes(const std::string& distances) {
    const std::string points =
        graph_.Floats({1, 2, cells_}, std::vector<float>(2 * static_cast<std::size_t>(cells_)));
    const std::string left = graph_.Node("Split", {distances}, 2), right = graph_.Other(1);
    graph_.SetInt("axis", 1);
    const std::string from = graph_.Node("Sub", {points, left});
    const std::string to = graph_.Node("Add", {points, right});
    const std::string middle =
        graph_.Node("Div", {graph_.Node("Add", {from, to}), graph_.Floats({}, {2})});
    const std::string boxes = graph_.Joined({middle, graph_.Node("Sub", {to, from})}, 1);
    const std::string strides =
        graph_.Floats({1, cells_}, std::vector<float>(static_cast<std::size_t>(cells_), 1));
    return graph_.Node("Mul", {boxes, strides});
  }

  std::string Masks() {
    std::vector<std::string> parts;
    const std::vector<float> values(static_cast<std::size_t>(yolo_.masks), 1);
    for (const int stride : strides_)
      parts.push_back(Flat(graph_.Grid(stride, values), yolo_.masks));
    return graph_.Joined(parts);
  }

  /// The boxes of the best scores, with operations that OpenCV 4.6 does not know.
  std::string Chosen(const std::string& output) {
    const std::string boxes = graph_.Node("Split", {graph_.Turned(output)}, 2);
    const std::string scores = graph_.Other(1);
    graph_.SetInt("axis", 2);
    graph_.SetInts("split", {4, yolo_.categories});
    const std::string flat = graph_.Flattened(scores);
    const std::string best = graph_.Node("TopK", {flat, graph_.Wholes({10})}, 2);
    const std::string index = graph_.Other(1);
    const std::string count = graph_.Whole(yolo_.categories);
    const std::string cell = graph_.Node("Div", {index, count});
    const std::string category = graph_.Node("Mod", {index, count});
    const std::string chosen = graph_.Node("GatherND", {boxes, cell});
    return graph_.Joined({chosen, best, category}, 2);
  }

  std::vector<float> Sides(int stride) const {
    const float strides = kReach / static_cast<float>(stride);
    if (yolo_.bins == 1) return std::vector<float>(4, strides);
    std::vector<float> logits;
    for (int i = 0; i < 4 * yolo_.bins; ++i) {
      const float share = 1 - std::abs(strides - static_cast<float>(i % yolo_.bins));
      logits.push_back(share > 0 ? std::log(share) : kNever);
    }
    return logits;
  }
  std::vector<float> Scores() const {
    std::vector<float> logits(static_cast<std::size_t>(yolo_.categories), kNever);
    logits[static_cast<std::size_t>(yolo_.best_category)] = std::log(0.8f / 0.2f);
    return logits;
  }

  const TinyYolo& yolo_;
  std::vector<int> strides_;
  TinyGraph graph_;
  int cells_ = 0;
};

}  // namespace

void WriteTinyYolo(const std::filesystem::path& file, const TinyYolo& yolo) {
  YoloWriter(yolo).Write(file);
}

}  // namespace plumbline
