// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include <imgui.h>

#include "ui/framework/theme.h"

namespace plumbline {

/// Distance that is as bad as colours show [m].
inline constexpr float kWorstResidual_m = 0.03f;

/// Colour of the distance of a model's point from the scan: green on it, over yellow to red; grey
/// where there is no scan (negative).
inline ImU32 ResidualColor(float distance_m) {
  constexpr ImU32 kNone = IM_COL32(96, 102, 112, 255), kGood = IM_COL32(72, 190, 120, 255),
                  kMiddle = IM_COL32(236, 206, 84, 255), kBad = IM_COL32(226, 70, 60, 255);
  if (distance_m < 0) return kNone;
  const float share = std::min(distance_m / kWorstResidual_m, 1.0f);
  return share < 0.5f ? Mixed(kGood, kMiddle, 2.0 * share) : Mixed(kMiddle, kBad, 2.0 * share - 1);
}

}  // namespace plumbline
