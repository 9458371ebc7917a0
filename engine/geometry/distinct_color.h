// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace plumbline {

/// RGB that tells number `index` from its neighbours: hues by the golden angle.
inline std::array<std::uint8_t, 3> DistinctColor(int index) {
  const double hue = std::fmod(index * 137.50776405, 360.0) / 60.0;
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    const double value = 0.9 * (1 - 0.65 * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
    return static_cast<std::uint8_t>(std::lround(255 * value));
  };
  return {channel(5), channel(3), channel(1)};
}

}  // namespace plumbline
