// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

#include <opencv2/core.hpp>

#include "engine/dataset/sequence.h"
#include "engine/sensor/camera.h"
#include "engine/synthetic/ray_tracer.h"

namespace plumbline {

/// How far the edges fall short of the truth.
struct EdgeFlaws {
  double dropped = 0.10;   ///< Share of edge pixels missing, in gaps.
  double jitter_px = 0.5;  ///< Standard deviation of the displacement along the normal.
  double spurious = 0.03;  ///< False edge pixels, as a share of the true ones.
};

/// Where a very good edge detector would find edges: depth steps and creases of all surfaces, and
/// strong boundaries of texture and shadow. One-pixel lines; the probability follows the contrast
/// in the picture.
/// @param maps     Of the middle of the exposure.
/// @param picture  RGB in [0, 1] without noise, CV_32FC3.
EdgeMap DetectSyntheticEdges(const PinholeCamera& camera, const SurfaceMaps& maps,
                             const cv::Mat& picture, const EdgeFlaws& flaws, std::uint64_t seed,
                             int frame);

/// Pixels on the near side of a depth step, and one side of creases; 255, CV_8U.
cv::Mat GeometricEdges(const PinholeCamera& camera, const SurfaceMaps& maps);

}  // namespace plumbline
