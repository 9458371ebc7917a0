// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/two_stage_network.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/vision/onnx_for_opencv.h"
#include "engine/vision/two_stage_detector.h"
#include "engine/vision/vision_resources.h"

namespace plumbline {
namespace {

/// Boxes of one pass of the head: weights are read once for so many, and its input (25 MB for 256
/// features) does not grow with the number of boxes.
constexpr std::size_t kHeadBatch = 128;
/// OpenCV multiplies so many columns at once; batches are filled up to a multiple, so that every
/// box goes through the same arithmetic.
constexpr int kHeadColumns = 32;

std::filesystem::path HeadFileOf(std::filesystem::path onnx_file) {
  return onnx_file.replace_extension(".head.onnx");
}

std::string BuiltinFile(std::string_view name) {
  return VisionResource("assets/networks/detector/" + std::string(name));
}

/// N x channels x bins as 1 x (channels * bins) x N x 1.
cv::Mat AsColumns(const cv::Mat& crops) {
  const int count = crops.size[0], length = static_cast<int>(crops.total()) / count;
  const int shape[] = {1, length, count, 1};
  cv::Mat columns(4, shape, CV_32FC1);
  cv::Mat turned(length, count, CV_32FC1, columns.data);
  cv::transpose(cv::Mat(count, length, CV_32FC1, crops.data), turned);
  return columns;
}

void Softmax(const float* logits, int count, float* probabilities) {
  const float highest = *std::max_element(logits, logits + count);
  float sum = 0;
  for (int i = 0; i < count; ++i) sum += probabilities[i] = std::exp(logits[i] - highest);
  for (int i = 0; i < count; ++i) probabilities[i] /= sum;
}

}  // namespace

std::string HashOfBuiltinDetector() {
  return HashHex(HashHex(BuiltinFile("detector.json")) + HashHex(BuiltinFile("detector.onnx")) +
                 HashHex(BuiltinFile("detector.head.onnx")));
}

cv::Size2f ImagePart(const FittedImage& fitted) {
  return {static_cast<float>(std::lround(fitted.original.width * fitted.scale_x)),
          static_cast<float>(std::lround(fitted.original.height * fitted.scale_y))};
}

Result<std::shared_ptr<TwoStageNetwork>> TwoStageNetwork::Load(
    const std::filesystem::path& onnx_file, NetworkSidecar sidecar) {
  const std::filesystem::path head_file = HeadFileOf(onnx_file);
  Result<Network> trunk = LoadNetwork(onnx_file, sidecar);
  if (!trunk.ok()) return trunk.error();
  if (std::error_code ignored; !std::filesystem::exists(head_file, ignored)) {
    return Error{ErrorCode::kNotFound, "the two-stage network '" + onnx_file.string() +
                                           "' has no head '" + head_file.string() +
                                           "' beside it; export_torchvision.py writes both"};
  }
  Result<Network> head = LoadNetwork(head_file, std::move(sidecar));
  if (!head.ok()) return head.error();
  trunk->content_hash += head->content_hash;
  return Tried(std::move(trunk).value(), std::move(head).value());
}

Result<std::shared_ptr<TwoStageNetwork>> TwoStageNetwork::Builtin() {
  Result<NetworkSidecar> sidecar =
      SidecarFromJson(nlohmann::json::parse(BuiltinFile("detector.json")));
  PLB_CHECK(sidecar.ok());
  const auto make = [&](std::string_view file) {
    return MakeNetwork(OnnxForOpenCv(BuiltinFile(file), std::nullopt), *sidecar, "builtin",
                       HashOfBuiltinDetector());
  };
  Result<Network> trunk = make("detector.onnx");
  if (!trunk.ok()) return trunk.error();
  Result<Network> head = make("detector.head.onnx");
  if (!head.ok()) return head.error();
  return Tried(std::move(trunk).value(), std::move(head).value());
}

Result<std::shared_ptr<TwoStageNetwork>> TwoStageNetwork::Tried(Network trunk, Network head) {
  std::shared_ptr<TwoStageNetwork> network(new TwoStageNetwork(std::move(trunk), std::move(head)));
  const cv::Mat gray(network->sidecar().height, network->sidecar().width, CV_8UC3,
                     cv::Scalar::all(128));
  const auto levels = network->RunTrunk(FitImage(gray, network->sidecar()));
  if (!levels.ok()) return levels.error();
  const Box2 any{0, 0, static_cast<float>(gray.cols), static_cast<float>(gray.rows)};
  const auto scores = network->RunHead(network->Features(*levels), {&any, 1});
  if (!scores.ok()) return scores.error();
  return network;
}

int TwoStageNetwork::channels_of(const cv::Mat& level, std::size_t index) const {
  return level.size[1] - 5 * sidecar().two_stage.anchors[index].count();
}

Status TwoStageNetwork::CheckLevels(const std::vector<cv::Mat>& levels) const {
  const NetworkSidecar& s = sidecar();
  bool good = levels.size() == s.strides.size();
  for (std::size_t i = 0; good && i < levels.size(); ++i) {
    const cv::Mat& level = levels[i];
    good = level.dims == 4 && level.type() == CV_32FC1 && level.isContinuous() &&
           level.size[0] == 1 && level.size[2] * s.strides[i] == s.height &&
           level.size[3] * s.strides[i] == s.width && channels_of(level, i) > 0 &&
           channels_of(level, i) == channels_of(levels[0], 0);
  }
  if (good) return {};
  return Error{ErrorCode::kInvalidInput,
               "the network '" + trunk_.name + "' gives outputs of " + ShapesText(levels) +
                   ", which its sidecar (kind two_stage, " + std::to_string(s.width) + "x" +
                   std::to_string(s.height) + ", " + std::to_string(s.strides.size()) +
                   " strides with their anchors) does not explain"};
}

Result<std::vector<cv::Mat>> TwoStageNetwork::RunTrunk(const FittedImage& fitted) {
  cv::Mat input = NetworkInput(fitted.image, sidecar());
  const cv::Size2f part = ImagePart(fitted);
  const cv::Rect inside(0, 0, static_cast<int>(part.width), static_cast<int>(part.height));
  for (int channel = 0; channel < 3; ++channel) {
    cv::Mat plane(fitted.image.size(), CV_32FC1, input.ptr<float>(0, channel));
    plane.colRange(inside.width, plane.cols).setTo(0);
    plane.rowRange(inside.height, plane.rows).setTo(0);
  }
  Result<std::vector<cv::Mat>> levels = RunNetworkOn(trunk_, input);
  if (!levels.ok()) return levels;
  if (Status status = CheckLevels(*levels); !status.ok()) return status.error();
  return levels;
}

std::vector<RegionProposal> TwoStageNetwork::Propose(const std::vector<cv::Mat>& levels,
                                                     const FittedImage& fitted) const {
  std::vector<ProposalLevel> proposal_levels;
  for (std::size_t i = 0; i < levels.size(); ++i)
    proposal_levels.push_back({levels[i], channels_of(levels[i], i), sidecar().strides[i]});
  return ProposeRegions(proposal_levels, sidecar().two_stage, ImagePart(fitted));
}

std::vector<FeatureMap> TwoStageNetwork::Features(const std::vector<cv::Mat>& levels) const {
  std::vector<FeatureMap> maps;
  for (int i = 0; i < sidecar().two_stage.crop_levels; ++i)
    maps.push_back(MakeFeatureMap(levels[i], 0, channels_of(levels[i], i), sidecar().strides[i]));
  return maps;
}

Result<cv::Mat> TwoStageNetwork::RunBatch(std::span<const FeatureMap> features,
                                          std::span<const Box2> boxes) {
  const int count = static_cast<int>(boxes.size());
  const int filled = (count + kHeadColumns - 1) / kHeadColumns * kHeadColumns;
  const cv::Mat crops = CropRegions(features, boxes, filled, sidecar().two_stage);
  const Result<std::vector<cv::Mat>> outputs =
      RunNetworkOn(head_, sidecar().two_stage.crop_columns ? AsColumns(crops) : crops);
  if (!outputs.ok()) return outputs.error();
  const int categories = static_cast<int>(sidecar().categories.size());
  const cv::Mat& rows = outputs->front();
  if (outputs->size() != 1 || rows.dims != 2 || rows.type() != CV_32FC1 || rows.rows != filled ||
      rows.cols != 5 * (1 + categories)) {
    return Error{ErrorCode::kInvalidInput,
                 "the head '" + head_.name + "' gives outputs of " + ShapesText(*outputs) +
                     " for crops of " + ShapesText({crops}) + ", but " +
                     std::to_string(categories) + " categories and the background need " +
                     std::to_string(filled) + "x" + std::to_string(5 * (1 + categories))};
  }
  return rows;
}

Result<HeadScores> TwoStageNetwork::RunHead(std::span<const FeatureMap> features,
                                            std::span<const Box2> boxes) {
  const std::lock_guard lock(head_mutex_);
  const int classes = 1 + static_cast<int>(sidecar().categories.size());
  const int count = static_cast<int>(boxes.size());
  HeadScores scores{cv::Mat(count, classes, CV_32FC1), cv::Mat(count, 4 * classes, CV_32FC1)};
  for (std::size_t start = 0; start < boxes.size(); start += kHeadBatch) {
    const auto batch = boxes.subspan(start, std::min(kHeadBatch, boxes.size() - start));
    const Result<cv::Mat> rows = RunBatch(features, batch);
    if (!rows.ok()) return rows.error();
    for (std::size_t i = 0; i < batch.size(); ++i) {
      const float* row = rows->ptr<float>(static_cast<int>(i));
      const int target = static_cast<int>(start + i);
      Softmax(row, classes, scores.probabilities.ptr<float>(target));
      std::copy(row + classes, row + 5 * classes, scores.deltas.ptr<float>(target));
    }
  }
  return scores;
}

}  // namespace plumbline
