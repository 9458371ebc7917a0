// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/film.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/base/random.h"
#include "engine/synthetic/material.h"

namespace plumbline {
namespace {

/// The sRGB curve as a table over [0, 1].
class EncodeTable {
 public:
  EncodeTable() {
    for (std::size_t i = 0; i < table_.size(); ++i) {
      table_[i] = EncodeSrgb(static_cast<float>(i) / static_cast<float>(table_.size() - 1));
    }
  }
  float operator()(float linear) const {
    const float position = std::clamp(linear, 0.0f, 1.0f) * static_cast<float>(table_.size() - 1);
    const auto i = std::min(static_cast<std::size_t>(position), table_.size() - 2);
    return table_[i] + (table_[i + 1] - table_[i]) * (position - static_cast<float>(i));
  }

 private:
  std::array<float, 4096> table_;
};

}  // namespace

float ToneCurve(float exposed) {
  // Straight in the shadows and mid tones, rolling off towards white (extended Reinhard with white
  // at 3.5).
  constexpr float kWhite = 3.5f;
  const float x = std::max(0.0f, exposed) * 1.25f;
  return std::min(1.0f, x * (1 + x / (kWhite * kWhite)) / (1 + 0.75f * x));
}

cv::Mat DevelopFilm(const cv::Mat& radiance, const FilmOptions& options) {
  static const EncodeTable kEncode;
  cv::Mat picture(radiance.size(), CV_32FC3);
  const float cx = 0.5f * static_cast<float>(radiance.cols),
              cy = 0.5f * static_cast<float>(radiance.rows);
  const float scale = 1 / (cx * cx + cy * cy);
  tbb::parallel_for(
      tbb::blocked_range<int>(0, radiance.rows, 16), [&](const tbb::blocked_range<int>& range) {
        for (int y = range.begin(); y < range.end(); ++y) {
          const auto* in = radiance.ptr<cv::Vec3f>(y);
          auto* out = picture.ptr<cv::Vec3f>(y);
          for (int x = 0; x < radiance.cols; ++x) {
            const float dx = static_cast<float>(x) - cx, dy = static_cast<float>(y) - cy;
            const float vignette = 1 - 0.22f * (dx * dx + dy * dy) * scale;
            for (int c = 0; c < 3; ++c)
              out[x][c] = kEncode(ToneCurve(in[x][c] * options.exposure * vignette));
          }
        }
      });
  return picture;
}

cv::Mat ExposeSensor(const cv::Mat& picture, const FilmOptions& options, std::uint64_t seed,
                     int frame) {
  cv::Mat image(picture.size(), CV_8UC3);
  const auto sigma = static_cast<float>(options.noise_levels);
  tbb::parallel_for(
      tbb::blocked_range<int>(0, picture.rows, 16), [&](const tbb::blocked_range<int>& range) {
        for (int y = range.begin(); y < range.end(); ++y) {
          Random random({.seed = seed,
                         .frame = static_cast<std::uint32_t>(frame),
                         .object = static_cast<std::uint32_t>(y),
                         .particle = 0x6e6f69});
          // The sum of four uniform bytes is close enough to a normal number: mean 510, variance 4
          // * (256^2 - 1) / 12.
          const auto normal = [&] {
            const std::uint32_t bits = random.Bits();
            const auto sum = static_cast<float>((bits & 255) + ((bits >> 8) & 255) +
                                                ((bits >> 16) & 255) + (bits >> 24));
            return (sum - 510) / 147.8f;
          };
          const auto* in = picture.ptr<cv::Vec3f>(y);
          auto* out = image.ptr<cv::Vec3b>(y);
          for (int x = 0; x < picture.cols; ++x) {
            const float common = 0.75f * normal();
            for (int c = 0; c < 3; ++c) {
              const float strength = sigma * (0.6f + 0.8f * in[x][2 - c] * (1.2f - in[x][2 - c]));
              out[x][c] = cv::saturate_cast<std::uint8_t>(255 * in[x][2 - c] +
                                                          strength * (common + 0.66f * normal()));
            }
          }
        }
      });
  return image;
}

}  // namespace plumbline
