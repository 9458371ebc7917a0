// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "ui/framework/frame_context.h"

namespace plumbline {

/// The four parameters of a place, as people read them: bearing to the right and down [deg],
/// log-depth, azimuth [deg].
struct Parameters {
  double value[4];
};

struct ParameterAxis {
  const char* name;
  const char* unit;
  const char* help;
  double least_reach;  ///< Narrower beliefs are not blown up further than this.
};
inline constexpr ParameterAxis kParameterAxes[] = {
    {"bearing, right", "\u00b0", "Angle to the right of the reference camera's axis.", 0.1},
    {"bearing, down", "\u00b0", "Angle below the reference camera's axis.", 0.1},
    {"log-depth", "", "Logarithm of the depth before the reference camera [m].", 0.004},
    {"azimuth", "\u00b0",
     "Turn about up. Where a shape looks the same from several sides, the "
     "true azimuth is the one nearest to the mean.",
     0.5}};
inline constexpr int kDepthAxis = 2, kAzimuthAxis = 3;
inline constexpr int kMarginalBins = 36;

/// Weighted histograms of an object's particles.
struct Marginals {
  double low[4], high[4], mean[4], std[4];
  double share[4][kMarginalBins] = {};
  std::optional<Parameters> truth;
};

Marginals MarginalsOf(const FrameContext& context, const ObjectReport& object);

}  // namespace plumbline
