// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/edge_network.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>

#include "engine/base/check.h"
#include "engine/base/files.h"
#include "engine/vision/network_cache.h"
#include "engine/vision/thinning.h"
#include "engine/vision/vision_resources.h"

namespace plumbline {
namespace {

/// Ridges that rise less than this in the network's raw output are not edges.
constexpr float kLeastRaw = 0.1f;

class EdgeNetwork : public EdgeDetector {
 public:
  EdgeNetwork(Network network, const EdgeOptions& options)
      : network_(std::move(network)),
        calibrate_(Curve(network_.sidecar, options)),
        cache_(options.cache),
        computation_("edges 1 " + network_.content_hash + (options.calibrate ? "" : " raw")) {}

  Result<EdgeMap> Detect(const Frame& frame) override {
    PLB_CHECK(frame.image.type() == CV_8UC3 && !frame.image.empty());
    if (!cache_) return Compute(frame);
    const std::string key = NetworkCacheKey(computation_, frame.image);
    if (const auto known = NetworkCache::Shared().Get(key)) {
      if (auto edges = DecodeEdges(*known)) return *std::move(edges);
    }
    Result<EdgeMap> edges = Compute(frame);
    if (edges.ok()) NetworkCache::Shared().Put(key, EncodeEdges(*edges));
    return edges;
  }

 private:
  Result<EdgeMap> Compute(const Frame& frame) {
    const NetworkSidecar& sidecar = network_.sidecar;
    double scale = 1.0 / sidecar.shrink;
    if (sidecar.multiple_of == 0) {
      scale = std::min({scale, static_cast<double>(sidecar.width) / frame.image.cols,
                        static_cast<double>(sidecar.height) / frame.image.rows});
    }
    cv::Mat image = frame.image, padded;
    if (scale < 1) {
      const cv::Size size(std::max(1, cvRound(image.cols * scale)),
                          std::max(1, cvRound(image.rows * scale)));
      cv::resize(frame.image, image, size, 0, 0, cv::INTER_AREA);
    }
    const cv::Size input = InputSize(image.size());
    cv::copyMakeBorder(image, padded, 0, input.height - image.rows, 0, input.width - image.cols,
                       cv::BORDER_REFLECT_101);
    const Result<std::vector<cv::Mat>> outputs = RunNetwork(network_, padded);
    if (!outputs.ok()) return outputs.error();
    if (outputs->size() != 1 || outputs->front().dims != 4 ||
        outputs->front().total() != static_cast<std::size_t>(input.area()) ||
        outputs->front().size[3] != input.width || outputs->front().type() != CV_32FC1) {
      return Error{ErrorCode::kInvalidInput,
                   "the network '" + network_.name + "' gives outputs of " + ShapesText(*outputs) +
                       ", which its sidecar does not explain; an edge network of this input gives "
                       "1x1x" +
                       std::to_string(input.height) + "x" + std::to_string(input.width)};
    }
    const cv::Mat all(input, CV_32FC1, const_cast<float*>(outputs->front().ptr<float>()));
    cv::Mat soft = all({0, 0, image.cols, image.rows});
    if (scale < 1) cv::resize(soft, soft, frame.image.size(), 0, 0, cv::INTER_LINEAR);
    return ThinRidges(soft, kLeastRaw, calibrate_);
  }
  cv::Size InputSize(const cv::Size& image) const {
    const NetworkSidecar& sidecar = network_.sidecar;
    const int m = sidecar.multiple_of;
    if (m == 0) return {sidecar.width, sidecar.height};
    return {(image.width + m - 1) / m * m, (image.height + m - 1) / m * m};
  }
  static CalibrationCurve Curve(const NetworkSidecar& sidecar, const EdgeOptions& options) {
    if (!options.calibrate) return CalibrationCurve({});
    // Precision of thinned pixels by raw score on BSDS500 val of a network trained with balanced
    // classes (docs/algorithms/edges.md).
    static const std::vector<std::pair<float, float>> kBalanced = {
        {0.0f, 0.0f},   {0.11f, 0.11f}, {0.22f, 0.19f}, {0.34f, 0.28f},
        {0.47f, 0.36f}, {0.59f, 0.45f}, {0.72f, 0.55f}, {0.78f, 0.62f},
        {0.85f, 0.70f}, {0.91f, 0.80f}, {0.97f, 0.92f}, {1.0f, 0.96f}};
    return CalibrationCurve(sidecar.calibration.empty() ? kBalanced : sidecar.calibration);
  }

  Network network_;
  CalibrationCurve calibrate_;
  bool cache_;
  std::string computation_;  ///< What decides the result besides the image; counts its versions.
};

/// Network and sidecar.
std::pair<std::string, std::string> BuiltinFiles(bool half) {
  const std::string folder = "assets/networks/edge/";
  const std::string name = half ? "edge_half" : "edge";
  return {VisionResource(folder + name + ".onnx"), VisionResource(folder + name + ".json")};
}

}  // namespace

Result<std::unique_ptr<EdgeDetector>> CreateEdgeNetwork(Network network,
                                                        const EdgeOptions& options) {
  if (network.sidecar.kind != NetworkKind::kEdge) {
    return Error{ErrorCode::kInvalidInput, "the network '" + network.name +
                                               "' finds objects, no edges (its sidecar's kind is " +
                                               std::string(NameOf(network.sidecar.kind)) +
                                               "); give it as --detector"};
  }
  Frame gray;
  const NetworkSidecar& sidecar = network.sidecar;
  const cv::Size size =
      sidecar.multiple_of > 0 ? cv::Size(64, 48) : cv::Size(sidecar.width, sidecar.height);
  gray.image = cv::Mat(size, CV_8UC3, cv::Scalar::all(128));
  EdgeOptions without_cache = options;
  without_cache.cache = false;
  if (const auto trial = EdgeNetwork(network, without_cache).Detect(gray); !trial.ok())
    return trial.error();
  return std::unique_ptr<EdgeDetector>(std::make_unique<EdgeNetwork>(std::move(network), options));
}

Result<std::unique_ptr<EdgeDetector>> BuiltinEdgeNetwork(bool half, const EdgeOptions& options) {
  const auto [onnx, text] = BuiltinFiles(half);
  Result<NetworkSidecar> sidecar = SidecarFromJson(nlohmann::json::parse(text));
  PLB_CHECK(sidecar.ok());
  Result<Network> network =
      MakeNetwork(onnx, std::move(sidecar).value(), half ? "builtin-half" : "builtin",
                  HashOfBuiltinEdges(half));
  if (!network.ok()) return network.error();
  return CreateEdgeNetwork(std::move(network).value(), options);
}

std::string HashOfBuiltinEdges(bool half) {
  const auto [onnx, text] = BuiltinFiles(half);
  return HashHex(onnx) + HashHex(text);
}

}  // namespace plumbline
