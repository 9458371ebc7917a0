// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/edge_network.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/base/check.h"
#include "engine/vision/network_cache.h"
#include "engine/vision/network_sidecar.h"
#include "engine/vision/thinning.h"

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
    const cv::Size input(network_.sidecar.width, network_.sidecar.height);
    const double scale = std::min({1.0, static_cast<double>(input.width) / frame.image.cols,
                                   static_cast<double>(input.height) / frame.image.rows});
    cv::Mat image = frame.image, padded;
    if (scale < 1) {
      const cv::Size size(std::max(1, cvRound(image.cols * scale)),
                          std::max(1, cvRound(image.rows * scale)));
      cv::resize(frame.image, image, size, 0, 0, cv::INTER_AREA);
    }
    cv::copyMakeBorder(image, padded, 0, input.height - image.rows, 0, input.width - image.cols,
                       cv::BORDER_REFLECT_101);
    const Result<cv::Mat> output = RunNetwork(network_, padded);
    if (!output.ok()) return output.error();
    const cv::Mat all(input, CV_32FC1, const_cast<float*>(output->ptr<float>()));
    cv::Mat soft = all({0, 0, image.cols, image.rows});
    if (scale < 1) cv::resize(soft, soft, frame.image.size(), 0, 0, cv::INTER_LINEAR);
    return ThinRidges(soft, kLeastRaw, calibrate_);
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

}  // namespace

Result<std::unique_ptr<EdgeDetector>> LoadEdgeNetwork(const std::filesystem::path& onnx_file,
                                                      const EdgeOptions& options) {
  const Result<NetworkSidecar> sidecar = ReadNetworkSidecar(onnx_file);
  if (!sidecar.ok()) return sidecar.error();
  Result<Network> network =
      LoadNetwork(onnx_file, NetworkKind::kEdge, {1, 1, sidecar->height, sidecar->width});
  if (!network.ok()) return network.error();
  return std::unique_ptr<EdgeDetector>(
      std::make_unique<EdgeNetwork>(std::move(network).value(), options));
}

}  // namespace plumbline
