// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace plumbline {

/// Of a pose in a file from the origin [m]. Beyond it doubles have no tenth of a nanometre left and
/// single precision no decimetre: the origin of a map is not the Earth's.
inline constexpr double kFarthest_m = 1e6;

}  // namespace plumbline
