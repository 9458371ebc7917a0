// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <numbers>

namespace plumbline {

// Angles are radians everywhere but in what people read and write.
inline constexpr double kRadPerDeg = std::numbers::pi / 180;  ///< radians = degrees * kRadPerDeg
inline constexpr double kDegPerRad = 180 / std::numbers::pi;  ///< degrees = radians * kDegPerRad
inline constexpr float kPiF = std::numbers::pi_v<float>;

}  // namespace plumbline
