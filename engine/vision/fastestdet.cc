// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/fastestdet.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "engine/base/check.h"
#include "engine/vision/network_cache.h"
#include "engine/vision/network_sidecar.h"
#include "engine/vision/proposals.h"

namespace plumbline {
namespace {

constexpr float kObjectnessPower = 0.6f;
constexpr float kClassPower = 0.4f;
/// Network input pixels per cell.
constexpr int kStride = 16;
/// Cells that score less than this say nothing about a category: with score * IoU they can add no
/// more.
constexpr float kLeastScore = 0.01f;

float Sigmoid(float x) { return 1 / (1 + std::exp(-x)); }

/// Image points are pixel centres at integers, so the image spans [-0.5, width - 0.5].
Box2 CellBox(const cv::Mat& output, int row, int column, const cv::Size& image) {
  const auto raw = [&](int channel) {
    return output.ptr<float>(0, channel)[row * output.size[3] + column];
  };
  const float center_x =
      (static_cast<float>(column) + std::tanh(raw(1))) / static_cast<float>(output.size[3]);
  const float center_y =
      (static_cast<float>(row) + std::tanh(raw(2))) / static_cast<float>(output.size[2]);
  const float half_width = Sigmoid(raw(3)) / 2, half_height = Sigmoid(raw(4)) / 2;
  const auto width = static_cast<float>(image.width), height = static_cast<float>(image.height);
  return {std::clamp((center_x - half_width) * width, 0.0f, width) - 0.5f,
          std::clamp((center_y - half_height) * height, 0.0f, height) - 0.5f,
          std::clamp((center_x + half_width) * width, 0.0f, width) - 0.5f,
          std::clamp((center_y + half_height) * height, 0.0f, height) - 0.5f};
}

class FastestDetections : public FrameDetections {
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

class FastestDet : public Detector {
 public:
  FastestDet(Network network, const DetectorOptions& options)
      : network_(std::move(network)), options_(options) {}
  Result<std::unique_ptr<const FrameDetections>> Detect(const Frame& frame) override {
    PLB_CHECK(frame.image.type() == CV_8UC3 && !frame.image.empty());
    const Result<cv::Mat> output = Output(frame.image);
    if (!output.ok()) return output.error();
    return DecodeFastestDet(*output, frame.image.size(), network_.sidecar.categories, options_);
  }

 private:
  Result<cv::Mat> Output(const cv::Mat& image) {
    if (!options_.cache) return RunNetwork(network_, image);
    const std::string key = NetworkCacheKey("output 1 " + network_.content_hash, image);
    if (const auto known = NetworkCache::Shared().Get(key)) {
      auto tensor = DecodeTensor(*known);
      if (tensor && tensor->dims == 4 &&
          tensor->size[1] == 5 + static_cast<int>(network_.sidecar.categories.size()))
        return *std::move(tensor);
    }
    Result<cv::Mat> output = RunNetwork(network_, image);
    if (output.ok()) NetworkCache::Shared().Put(key, EncodeTensor(*output));
    return output;
  }

  Network network_;
  DetectorOptions options_;
};

}  // namespace

std::unique_ptr<const FrameDetections> DecodeFastestDet(const cv::Mat& output,
                                                        const cv::Size& image,
                                                        const std::vector<std::string>& categories,
                                                        const DetectorOptions& options) {
  const int num_categories = static_cast<int>(categories.size());
  PLB_CHECK(output.dims == 4 && output.size[0] == 1 && output.size[1] == 5 + num_categories &&
            output.type() == CV_32FC1 && output.isContinuous());
  const int columns = output.size[3], cells = output.size[2] * columns;
  std::vector<ScoredBoxes> dense(categories.size());
  std::vector<Detection> proposals;
  for (int cell = 0; cell < cells; ++cell) {
    const float objectness = output.ptr<float>(0, 0)[cell];
    const float object_part = std::pow(std::clamp(objectness, 0.0f, 1.0f), kObjectnessPower);
    if (!(object_part >= kLeastScore)) continue;
    const Box2 box = CellBox(output, cell / columns, cell % columns, image);
    // score >= kLeastScore, solved for the class probability: few cells need the power.
    const float least = std::pow(kLeastScore / object_part, 1 / kClassPower);
    int best = 0;
    float best_probability = -1;
    for (int category = 0; category < num_categories; ++category) {
      const float probability = output.ptr<float>(0, 5 + category)[cell];
      if (probability > best_probability) {
        best = category;
        best_probability = probability;
      }
      if (!(probability >= least)) continue;
      dense[category].Add(box, std::min(1.0f, object_part * std::pow(probability, kClassPower)));
    }
    if (!(best_probability >= least) || box.empty()) continue;
    const float score = std::min(1.0f, object_part * std::pow(best_probability, kClassPower));
    if (score >= options.min_score) proposals.push_back({box, categories[best], score});
  }
  auto result = std::make_unique<FastestDetections>();
  result->proposals_ = SuppressNonMaxima(std::move(proposals), options.nms_iou);
  for (int category = 0; category < num_categories; ++category) {
    dense[category].Sort();
    result->dense_.emplace(categories[category], std::move(dense[category]));
  }
  return result;
}

Result<std::unique_ptr<Detector>> LoadFastestDet(const std::filesystem::path& onnx_file,
                                                 const DetectorOptions& options) {
  Result<NetworkSidecar> sidecar = ReadNetworkSidecar(onnx_file);
  if (!sidecar.ok()) return sidecar.error();
  Result<Network> network = LoadNetwork(onnx_file, NetworkKind::kFastestDet,
                                        {1, 5 + static_cast<int>(sidecar->categories.size()),
                                         sidecar->height / kStride, sidecar->width / kStride});
  if (!network.ok()) return network.error();
  return std::unique_ptr<Detector>(
      std::make_unique<FastestDet>(std::move(network).value(), options));
}

}  // namespace plumbline
