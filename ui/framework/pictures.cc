// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/pictures.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "ui/framework/theme.h"

namespace plumbline {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kEdgeSaturation = 150;

/// Viridis from far (0) to near (255), leaving out its darkest part so that far things stand off
/// the ground.
const cv::Mat& DepthTable() {
  static const cv::Mat table = [] {
    cv::Mat ramp(1, 256, CV_8U), colored;
    for (int i = 0; i < 256; ++i)
      ramp.at<std::uint8_t>(i) = static_cast<std::uint8_t>(30 + i * 225 / 255);
    cv::applyColorMap(ramp, colored, cv::COLORMAP_VIRIDIS);
    return colored;
  }();
  return table;
}

int DepthIndex(double depth_m, const DepthRange& range) {
  const double share = (range.far_m - depth_m) / (range.far_m - range.near_m);
  return static_cast<int>(std::lround(255 * std::clamp(share, 0.0, 1.0)));
}

}  // namespace

cv::Mat EdgePicture(const cv::Mat& probability, const cv::Mat& angle, bool thick) {
  if (probability.empty()) return {};
  cv::Mat hue;
  if (angle.empty()) {
    hue = cv::Mat(probability.size(), CV_8U, cv::Scalar(0));
  } else {
    angle.convertTo(hue, CV_8U, 180.0 / 256.0);
  }
  const cv::Mat saturation(probability.size(), CV_8U,
                           cv::Scalar(angle.empty() ? 0 : kEdgeSaturation));
  cv::Mat value, hsv, picture;
  // Weak edges would drown on a dark screen: lift them.
  probability.convertTo(value, CV_32F, 1.0 / 255.0);
  cv::sqrt(value, value);
  value.convertTo(value, CV_8U, 255.0);
  cv::merge(std::vector<cv::Mat>{hue, saturation, value}, hsv);
  cv::cvtColor(hsv, picture, cv::COLOR_HSV2BGR);
  if (thick) cv::dilate(picture, picture, cv::Mat::ones(2, 2, CV_8U));
  return picture;
}

ImU32 OrientationColor(double angle_rad) {
  float r = 0, g = 0, b = 0;
  ImGui::ColorConvertHSVtoRGB(static_cast<float>(angle_rad / kPi), kEdgeSaturation / 255.0f, 1, r,
                              g, b);
  return ImGui::ColorConvertFloat4ToU32({r, g, b, 1});
}

DepthRange RangeOf(const cv::Mat& depth) {
  if (depth.empty()) return {};
  double low = 0, high = 0;
  cv::minMaxLoc(depth, &low, &high, nullptr, nullptr, depth > 0);
  if (high <= 0) return {};
  return {0.5 * std::floor(low / 0.5), 0.5 * std::floor(high / 0.5) + 0.5};
}

ImU32 DepthColor(double depth_m, const DepthRange& range) {
  const auto c = DepthTable().at<cv::Vec3b>(DepthIndex(depth_m, range));
  return IM_COL32(c[2], c[1], c[0], 255);
}

cv::Mat DepthPicture(const cv::Mat& depth, const DepthRange& range) {
  if (depth.empty()) return {};
  cv::Mat picture(depth.size(), CV_8UC3, cv::Scalar(18, 15, 13));
  if (range.empty()) return picture;
  const auto* table = DepthTable().ptr<cv::Vec3b>();
  for (int y = 0; y < depth.rows; ++y) {
    const auto* z = depth.ptr<float>(y);
    auto* out = picture.ptr<cv::Vec3b>(y);
    for (int x = 0; x < depth.cols; ++x) {
      if (z[x] > 0) out[x] = table[DepthIndex(z[x], range)];
    }
  }
  return picture;
}

cv::Mat MaskPicture(const cv::Mat& image, const cv::Mat& depth, const cv::Mat& id,
                    const DepthRange& range, const ObjectLooks& looks) {
  if (image.empty()) return {};
  cv::Mat picture;
  image.convertTo(picture, CV_8UC3, 0.45);
  if (id.empty() || depth.empty() || range.empty()) return picture;
  int last = 0;
  cv::Vec3b color;
  for (int y = 0; y < picture.rows; ++y) {
    const int map_y = y * id.rows / picture.rows;
    const auto* ids = id.ptr<std::uint16_t>(map_y);
    const auto* z = depth.ptr<float>(map_y);
    auto* out = picture.ptr<cv::Vec3b>(y);
    for (int x = 0; x < picture.cols; ++x) {
      const int map_x = x * id.cols / picture.cols;
      if (ids[map_x] == 0) continue;
      if (ids[map_x] != last) {
        last = ids[map_x];
        const auto look = looks.find({last});
        color = BgrOf(ColorOfLook(look != looks.end() ? look->second : ObjectLook{}));
      }
      const double far =
          std::clamp((z[map_x] - range.near_m) / (range.far_m - range.near_m), 0.0, 1.0);
      const double shade = 0.30 + 0.70 * far;
      for (int c = 0; c < 3; ++c) {
        out[x][c] = cv::saturate_cast<std::uint8_t>(0.35 * out[x][c] + 0.85 * shade * color[c]);
      }
    }
  }
  return picture;
}

}  // namespace plumbline
