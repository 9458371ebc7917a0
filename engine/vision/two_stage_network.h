// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include <opencv2/core.hpp>

#include "engine/base/result.h"
#include "engine/geometry/box.h"
#include "engine/vision/network.h"
#include "engine/vision/region_proposals.h"
#include "engine/vision/roi_align.h"

namespace plumbline {

/// What the second stage makes of boxes: for each box a row of probabilities of the background and
/// of all categories, which sum to 1, and a row of as many times four deltas.
struct HeadScores {
  cv::Mat probabilities;  ///< N x (1 + categories)
  cv::Mat deltas;         ///< N x 4 (1 + categories)
};

/// The two networks of a two-stage detector. All boxes are [px of the input] from its edge.
class TwoStageNetwork {
 public:
  /// FILE.onnx and, beside it, FILE.head.onnx; both are run once to see that their outputs are what
  /// the sidecar says. Errors: kNotFound, kCorrupt, kInvalidInput, naming the file.
  static Result<std::shared_ptr<TwoStageNetwork>> Load(const std::filesystem::path& onnx_file,
                                                       NetworkSidecar sidecar);
  /// The one that is built into the program (assets/networks/detector).
  static Result<std::shared_ptr<TwoStageNetwork>> Builtin();

  const NetworkSidecar& sidecar() const { return trunk_.sidecar; }
  /// Of both files and the sidecar.
  const std::string& content_hash() const { return trunk_.content_hash; }

  /// A tensor a level, valid until the next call. Beyond the image the normalised input is 0, as
  /// torchvision pads. Not safe to call from several threads. Errors: kCorrupt, kInvalidInput.
  Result<std::vector<cv::Mat>> RunTrunk(const FittedImage& fitted);
  /// Whether these are levels as the trunk gives them; if not, what is wrong with them.
  Status CheckLevels(const std::vector<cv::Mat>& levels) const;

  /// The first stage, of checked levels.
  std::vector<RegionProposal> Propose(const std::vector<cv::Mat>& levels,
                                      const FittedImage& fitted) const;
  /// What crops are taken from, of checked levels.
  std::vector<FeatureMap> Features(const std::vector<cv::Mat>& levels) const;

  /// The second stage for all boxes, in batches; a box's scores do not depend on the others, nor on
  /// the number of threads. Safe to call from several threads, which wait for one another. Errors:
  /// kCorrupt, kInvalidInput, naming the head's file.
  Result<HeadScores> RunHead(std::span<const FeatureMap> features, std::span<const Box2> boxes);

 private:
  /// Runs both once.
  static Result<std::shared_ptr<TwoStageNetwork>> Tried(Network trunk, Network head);
  TwoStageNetwork(Network trunk, Network head) : trunk_(std::move(trunk)), head_(std::move(head)) {}
  int channels_of(const cv::Mat& level, std::size_t index) const;
  /// N x 5 (1 + categories): logits, then deltas.
  Result<cv::Mat> RunBatch(std::span<const FeatureMap> features, std::span<const Box2> boxes);

  Network trunk_;
  std::mutex head_mutex_;
  Network head_;
};

/// The image's part of the network's input [px].
cv::Size2f ImagePart(const FittedImage& fitted);

}  // namespace plumbline
