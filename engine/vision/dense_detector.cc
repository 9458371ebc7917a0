// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/dense_detector.h"

#include "engine/base/check.h"
#include "engine/vision/detector_heads.h"
#include "engine/vision/network_cache.h"

namespace plumbline {
namespace {

class DenseDetector : public Detector {
 public:
  DenseDetector(Network network, const DetectorOptions& options)
      : network_(std::move(network)), options_(options) {}
  Result<std::unique_ptr<const FrameDetections>> Detect(const Frame& frame) override {
    PLB_CHECK(frame.image.type() == CV_8UC3 && !frame.image.empty());
    const FittedImage fitted = FitImage(frame.image, network_.sidecar);
    if (options_.cache) {
      const std::string key = NetworkCacheKey("outputs 1 " + network_.content_hash, frame.image);
      if (const auto known = NetworkCache::Shared().Get(key)) {
        if (const auto outputs = DecodeTensors(*known)) {
          auto detections = Decode(*outputs, fitted);
          if (detections.ok()) return detections;
        }
      }
      const Result<std::vector<cv::Mat>> outputs = RunNetwork(network_, fitted.image);
      if (!outputs.ok()) return outputs.error();
      NetworkCache::Shared().Put(key, EncodeTensors(*outputs));
      return Decode(*outputs, fitted);
    }
    const Result<std::vector<cv::Mat>> outputs = RunNetwork(network_, fitted.image);
    if (!outputs.ok()) return outputs.error();
    return Decode(*outputs, fitted);
  }

 private:
  Result<std::unique_ptr<const FrameDetections>> Decode(const std::vector<cv::Mat>& outputs,
                                                        const FittedImage& fitted) const {
    auto detections = DecodeDetections(outputs, network_.sidecar, fitted, options_);
    if (detections.ok()) return detections;
    return Error{detections.error().code,
                 "the network '" + network_.name + "' " + detections.error().message};
  }

  Network network_;
  DetectorOptions options_;
};

}  // namespace

Result<std::unique_ptr<Detector>> CreateDenseDetector(Network network,
                                                      const DetectorOptions& options) {
  Frame gray;
  gray.image =
      cv::Mat(network.sidecar.height, network.sidecar.width, CV_8UC3, cv::Scalar::all(128));
  DetectorOptions without_cache = options;
  without_cache.cache = false;
  if (const auto trial = DenseDetector(network, without_cache).Detect(gray); !trial.ok())
    return trial.error();
  return std::unique_ptr<Detector>(std::make_unique<DenseDetector>(std::move(network), options));
}

}  // namespace plumbline
