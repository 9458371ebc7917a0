// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/two_stage_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>
#include <unordered_map>

#include <tbb/task_arena.h>

#include "engine/base/check.h"
#include "engine/vision/network_cache.h"
#include "engine/vision/proposals.h"
#include "engine/vision/two_stage_network.h"

namespace plumbline {
namespace {

/// Outputs of the trunk are kept up to this size: 0.4 MB for mobilenet at 448x320, but 74 MB for
/// resnet50 at 1088x832, which takes about as long to read as to compute and would push everything
/// else out. Top-down scores need the features, so that proposals alone would save nothing.
constexpr std::size_t kMostCachedBytes = 4 << 20;
constexpr float kLeastBoxSide = 1e-2f;  // [px of the input], as torchvision
constexpr float kStepsPerPixel = 4;     // of boxes that are scored, in the image
/// Of the built-in detector large boxes have longer steps, powers of two times as long, up to a
/// side over this: its head sees 7 x 7 bins, and hypotheses of one object then ask much the same.
constexpr int kStepsPerSide = 16;
constexpr int kExact = 0;

/// A box of the image in steps from its edge.
using BoxKey = std::array<int, 4>;

struct BoxKeyHash {
  std::size_t operator()(const BoxKey& key) const {
    std::size_t hash = 0;
    for (const int number : key)
      hash = (hash ^ static_cast<std::size_t>(number)) * 0x9E3779B97F4A7C15u;
    return hash ^ (hash >> 32);
  }
};

/// Never beyond `end`, the image's.
void RoundTogether(int steps_per_side, int end, int& low, int& high) {
  if (steps_per_side == kExact) return;
  int step = 1;
  while (2 * step * steps_per_side <= high - low) step *= 2;
  low = (low + step / 2) / step * step;
  high = std::min((high + step / 2) / step * step, end);
}

/// Edges of a box: pixel centres lie at integers, the image spans [-0.5, size - 0.5].
std::optional<BoxKey> KeyOf(const Box2& box, const cv::Size& image, int steps_per_side) {
  if (box.empty()) return std::nullopt;
  const auto steps = [](float at, int size) {
    const float inside = std::clamp(at + 0.5f, 0.0f, static_cast<float>(size));
    return static_cast<int>(std::lround(inside * kStepsPerPixel));
  };
  BoxKey key = {steps(box.x0, image.width), steps(box.y0, image.height), steps(box.x1, image.width),
                steps(box.y1, image.height)};
  if (key[0] >= key[2] || key[1] >= key[3]) return std::nullopt;
  constexpr auto kSteps = static_cast<int>(kStepsPerPixel);
  RoundTogether(steps_per_side, kSteps * image.width, key[0], key[2]);
  RoundTogether(steps_per_side, kSteps * image.height, key[1], key[3]);
  return key;
}

class TwoStageDetections : public FrameDetections {
 public:
  TwoStageDetections(std::shared_ptr<TwoStageNetwork> network, std::vector<FeatureMap> features,
                     const FittedImage& fitted, int steps_per_side,
                     std::vector<Detection> proposals)
      : network_(std::move(network)),
        features_(std::move(features)),
        image_(fitted.original),
        scale_x_(static_cast<float>(fitted.scale_x)),
        scale_y_(static_cast<float>(fitted.scale_y)),
        steps_per_side_(steps_per_side),
        proposals_(std::move(proposals)) {}

  std::span<const Detection> proposals() const override { return proposals_; }

  void ScoreBoxes(std::string_view category, std::span<const Box2> boxes,
                  std::span<float> scores) const override {
    PLB_CHECK(boxes.size() == scores.size());
    const auto& categories = network_->sidecar().categories;
    const auto found = std::find(categories.begin(), categories.end(), category);
    std::fill(scores.begin(), scores.end(), 0.0f);
    if (found == categories.end()) return;
    const auto column = static_cast<std::size_t>(found - categories.begin());
    const std::lock_guard lock(mutex_);
    std::vector<std::optional<std::size_t>> rows(boxes.size());
    std::vector<BoxKey> unknown;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      const std::optional<BoxKey> key = KeyOf(boxes[i], image_, steps_per_side_);
      if (!key) continue;
      const auto [entry, is_new] = rows_.try_emplace(*key, rows_.size());
      if (is_new) unknown.push_back(*key);
      rows[i] = entry->second;
    }
    if (!unknown.empty()) Remember(unknown);
    for (std::size_t i = 0; i < boxes.size(); ++i)
      if (rows[i]) scores[i] = probabilities_[*rows[i] * categories.size() + column];
  }

 private:
  /// Appends what the head says of these boxes.
  void Remember(const std::vector<BoxKey>& keys) const {
    std::vector<Box2> boxes;
    const float across = scale_x_ / kStepsPerPixel, down = scale_y_ / kStepsPerPixel;
    for (const BoxKey& key : keys) {
      boxes.push_back({static_cast<float>(key[0]) * across, static_cast<float>(key[1]) * down,
                       static_cast<float>(key[2]) * across, static_cast<float>(key[3]) * down});
    }
    // While it waits, this thread must not take up a task that asks the same frame: it would wait
    // for itself.
    const Result<HeadScores> scores =
        tbb::this_task_arena::isolate([&] { return network_->RunHead(features_, boxes); });
    if (!scores.ok()) {  // no row without its probabilities
      rows_.clear();
      probabilities_.clear();
    }
    const cv::Mat& all = scores.value().probabilities;
    for (int i = 0; i < all.rows; ++i) {
      const float* row = all.ptr<float>(i);
      probabilities_.insert(probabilities_.end(), row + 1, row + all.cols);
    }
  }

  const std::shared_ptr<TwoStageNetwork> network_;
  const std::vector<FeatureMap> features_;
  const cv::Size image_;
  const float scale_x_, scale_y_;  ///< [px of the input per px of the image]
  const int steps_per_side_;
  const std::vector<Detection> proposals_;

  mutable std::mutex mutex_;
  mutable std::unordered_map<BoxKey, std::size_t, BoxKeyHash> rows_;
  mutable std::vector<float> probabilities_;  ///< All categories of a row, without background.
};

class TwoStageDetector : public Detector {
 public:
  TwoStageDetector(std::shared_ptr<TwoStageNetwork> network, const DetectorOptions& options,
                   int steps_per_side)
      : network_(std::move(network)), options_(options), steps_per_side_(steps_per_side) {}

  Result<std::unique_ptr<const FrameDetections>> Detect(const Frame& frame) override {
    PLB_CHECK(frame.image.type() == CV_8UC3 && !frame.image.empty());
    const FittedImage fitted = FitImage(frame.image, network_->sidecar());
    const Result<std::vector<cv::Mat>> levels = LevelsOf(frame, fitted);
    if (!levels.ok()) return levels.error();
    std::vector<FeatureMap> features = network_->Features(*levels);
    std::vector<Box2> regions;
    for (const RegionProposal& region : network_->Propose(*levels, fitted))
      regions.push_back(region.box);
    const Result<HeadScores> scores = network_->RunHead(features, regions);
    if (!scores.ok()) return scores.error();
    return std::unique_ptr<const FrameDetections>(std::make_unique<TwoStageDetections>(
        network_, std::move(features), fitted, steps_per_side_, Choose(regions, *scores, fitted)));
  }

 private:
  Result<std::vector<cv::Mat>> LevelsOf(const Frame& frame, const FittedImage& fitted) {
    if (!options_.cache) return network_->RunTrunk(fitted);
    const std::string key = NetworkCacheKey("levels 1 " + network_->content_hash(), frame.image);
    if (const auto known = NetworkCache::Shared().Get(key)) {
      auto levels = DecodeTensors(*known);
      if (levels && network_->CheckLevels(*levels).ok()) return *std::move(levels);
    }
    Result<std::vector<cv::Mat>> levels = network_->RunTrunk(fitted);
    if (!levels.ok()) return levels;
    std::size_t bytes = 0;
    for (const cv::Mat& level : *levels) bytes += level.total() * level.elemSize();
    if (bytes <= kMostCachedBytes) NetworkCache::Shared().Put(key, EncodeTensors(*levels));
    return levels;
  }

  /// Regions moved by each category that scores enough, in the image, without those covered.
  std::vector<Detection> Choose(const std::vector<Box2>& regions, const HeadScores& scores,
                                const FittedImage& fitted) const {
    const NetworkSidecar& s = network_->sidecar();
    const cv::Size2f part = ImagePart(fitted);
    const auto across = static_cast<float>(fitted.scale_x),
               down = static_cast<float>(fitted.scale_y);
    std::vector<Detection> detections;
    for (std::size_t i = 0; i < regions.size(); ++i) {
      const float* probabilities = scores.probabilities.ptr<float>(static_cast<int>(i));
      const float* deltas = scores.deltas.ptr<float>(static_cast<int>(i));
      for (std::size_t k = 1; k <= s.categories.size(); ++k) {
        if (!(probabilities[k] >= options_.min_score)) continue;
        const std::array<float, 4> moves = {deltas[4 * k], deltas[4 * k + 1], deltas[4 * k + 2],
                                            deltas[4 * k + 3]};
        const Box2 box = ClippedBox(MovedBox(regions[i], moves, s.two_stage.box_weights), part);
        if (!(box.width() >= kLeastBoxSide && box.height() >= kLeastBoxSide)) continue;
        detections.push_back({{box.x0 / across - 0.5f, box.y0 / down - 0.5f, box.x1 / across - 0.5f,
                               box.y1 / down - 0.5f},
                              s.categories[k - 1],
                              probabilities[k]});
      }
    }
    detections = SuppressNonMaxima(std::move(detections), options_.nms_iou);
    if (std::ssize(detections) > s.two_stage.most_boxes)
      detections.resize(static_cast<std::size_t>(s.two_stage.most_boxes));
    return detections;
  }

  std::shared_ptr<TwoStageNetwork> network_;
  DetectorOptions options_;
  int steps_per_side_;
};

}  // namespace

Result<std::unique_ptr<Detector>> CreateTwoStageDetector(const std::filesystem::path& onnx_file,
                                                         NetworkSidecar sidecar,
                                                         const DetectorOptions& options) {
  auto network = TwoStageNetwork::Load(onnx_file, std::move(sidecar));
  if (!network.ok()) return network.error();
  return std::unique_ptr<Detector>(
      std::make_unique<TwoStageDetector>(std::move(network).value(), options, kExact));
}

Result<std::unique_ptr<Detector>> BuiltinDetector(const DetectorOptions& options) {
  auto network = TwoStageNetwork::Builtin();
  if (!network.ok()) return network.error();
  return std::unique_ptr<Detector>(
      std::make_unique<TwoStageDetector>(std::move(network).value(), options, kStepsPerSide));
}

}  // namespace plumbline
