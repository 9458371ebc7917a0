// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "engine/geometry/angles.h"

namespace plumbline {

/// A number as people read it: what rounds to zero has no sign.
inline std::string NumberText(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find_first_of("123456789") == std::string::npos && text.starts_with('-'))
    text.erase(0, 1);
  return text;
}

/// Degrees with their sign, in (-180, 180] after rounding.
inline std::string AngleText(double angle_rad, int decimals = 0) {
  std::string text =
      NumberText(kDegPerRad * std::remainder(angle_rad, 2 * std::numbers::pi), decimals);
  if (text.starts_with("-180") && text.find_first_of("123456789", 4) == std::string::npos)
    text.erase(0, 1);
  return text + "\u00b0";
}

}  // namespace plumbline
