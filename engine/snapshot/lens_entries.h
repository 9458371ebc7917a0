// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace plumbline {

/// One number of a lens as people read it.
struct LensEntry {
  const char* name;
  const char* key;  ///< In JSON, in the unit of LensVector (vio/filter_state.h).
  const char* unit;
  double factor = 1;  ///< From the LensVector's unit to `unit`.
  int digits = 0;     ///< Behind the point.
};

/// In the order of LensVector.
inline constexpr std::array<LensEntry, 9> kLensEntries = {{
    {"fx", "fx_px", "px", 1, 2},
    {"fy", "fy_px", "px", 1, 2},
    {"cx", "cx_px", "px", 1, 2},
    {"cy", "cy_px", "px", 1, 2},
    {"distortion 1", "distortion_1", "", 1, 5},
    {"distortion 2", "distortion_2", "", 1, 5},
    {"distortion 3", "distortion_3", "", 1, 5},
    {"distortion 4", "distortion_4", "", 1, 5},
    {"read-out", "read_out_s", "ms", 1e3, 3},
}};

}  // namespace plumbline
