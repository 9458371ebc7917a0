// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

namespace plumbline {

/// From linear radiance to what a camera stores.
struct FilmOptions {
  float exposure = 1;
  double noise_levels =
      3;  ///< Standard deviation of the sensor noise in grey levels of 256, at mid grey.
};

/// Tone-mapped picture without noise, sRGB-encoded, RGB in [0, 1], CV_32FC3. @param radiance  RGB,
/// CV_32FC3.
cv::Mat DevelopFilm(const cv::Mat& radiance, const FilmOptions& options);

/// Adds sensor noise and rounds: BGR, CV_8UC3. Random numbers depend on (seed, frame, pixel) alone.
cv::Mat ExposeSensor(const cv::Mat& picture, const FilmOptions& options, std::uint64_t seed,
                     int frame);

/// The tone curve: linear scene light, already exposed, to linear display light in [0, 1].
float ToneCurve(float exposed);

}  // namespace plumbline
