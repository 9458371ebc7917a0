// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/edge_gradient.h"

#include <cmath>

#include <opencv2/imgproc.hpp>

#include "engine/base/check.h"
#include "engine/vision/thinning.h"

namespace plumbline {
namespace {

class GradientEdges : public EdgeDetector {
 public:
  explicit GradientEdges(const EdgeOptions& options) : options_(options) {}
  Result<EdgeMap> Detect(const Frame& frame) override {
    PLB_CHECK(frame.image.type() == CV_8UC3 && !frame.image.empty());
    cv::Mat image = frame.image, tensor;
    for (int level = 0; level < 3; ++level) {
      cv::Mat smooth, dx, dy;
      cv::GaussianBlur(image, smooth, {}, 1.0);
      cv::Sobel(smooth, dx, CV_32F, 1, 0);
      cv::Sobel(smooth, dy, CV_32F, 0, 1);
      cv::Mat own(image.size(), CV_32FC3);
      for (int y = 0; y < image.rows; ++y) {
        for (int x = 0; x < image.cols; ++x) {
          const auto& u = dx.at<cv::Vec3f>(y, x);
          const auto& v = dy.at<cv::Vec3f>(y, x);
          own.at<cv::Vec3f>(y, x) = {u.dot(u), u.dot(v), v.dot(v)};
        }
      }
      if (level == 0) {
        tensor = own;
      } else {
        cv::resize(own, own, tensor.size(), 0, 0, cv::INTER_LINEAR);
        tensor += own;
      }
      cv::resize(image, image, {std::max(1, image.cols / 2), std::max(1, image.rows / 2)}, 0, 0,
                 cv::INTER_AREA);
    }
    return Thin(tensor);
  }
  std::string Description() const override { return "gradient"; }

 private:
  EdgeMap Thin(const cv::Mat& tensor) const {
    cv::Mat strength(tensor.size(), CV_32FC1);
    for (int y = 0; y < tensor.rows; ++y) {
      for (int x = 0; x < tensor.cols; ++x) {
        const auto& t = tensor.at<cv::Vec3f>(y, x);
        strength.at<float>(y, x) =
            std::sqrt(0.5f * (t[0] + t[2] + std::hypot(t[0] - t[2], 2 * t[1])));
      }
    }
    EdgeMap edges{cv::Mat::zeros(tensor.size(), CV_8UC1), cv::Mat::zeros(tensor.size(), CV_8UC1)};
    for (int y = 1; y + 2 < tensor.rows; ++y) {
      for (int x = 1; x + 2 < tensor.cols; ++x) {
        const float here = strength.at<float>(y, x);
        if (here < 20) continue;
        const auto& t = tensor.at<cv::Vec3f>(y, x);
        const float normal = 0.5f * std::atan2(2 * t[1], t[0] - t[2]);
        const float nx = std::cos(normal), ny = std::sin(normal);
        const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
        if (here < Interpolate(strength, fx + nx, fy + ny) ||
            here <= Interpolate(strength, fx - nx, fy - ny))
          continue;
        const float raw = here / (here + 200);
        edges.probability.at<std::uint8_t>(y, x) = ProbabilityToByte(raw);
        edges.angle.at<std::uint8_t>(y, x) = AngleToByte(normal);
      }
    }
    RemoveSpareCorners(strength, edges.probability);
    edges.angle.setTo(0, edges.probability == 0);
    return edges;
  }
  EdgeOptions options_;
};

}  // namespace

std::unique_ptr<EdgeDetector> CreateGradientEdgeDetector(const EdgeOptions& options) {
  return std::make_unique<GradientEdges>(options);
}

}  // namespace plumbline
