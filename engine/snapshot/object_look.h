// SPDX-License-Identifier: Apache-2.0
#pragma once

// How the objects of a run are told apart: the same in images, map, lanes, lists, films and
// reports.

#include <array>
#include <cstdint>
#include <map>

#include "engine/base/ids.h"

namespace plumbline {

struct LookColor {
  std::uint8_t red = 0, green = 0, blue = 0;
  bool operator==(const LookColor&) const = default;
};

/// The first ones differ most. Any two are at least 11 apart (CIEDE2000) for protanopes and
/// deuteranopes, 15 for others, stand out from both themes' panels, and are neither the truth's
/// green nor the path's orange (tests/engine/analysis/object_looks_test.cc).
inline constexpr std::array<LookColor, 12> kLookColors = {{{119, 187, 255},
                                                           {221, 170, 0},
                                                           {221, 34, 119},
                                                           {85, 187, 170},
                                                           {153, 85, 187},
                                                           {221, 51, 17},
                                                           {255, 136, 170},
                                                           {0, 136, 51},
                                                           {119, 136, 255},
                                                           {0, 136, 119},
                                                           {170, 153, 102},
                                                           {170, 136, 187}}};
/// Of an object that was never confirmed.
inline constexpr LookColor kNeutralLook = {160, 168, 178};

struct ObjectLook {
  int color = -1;       ///< Index into kLookColors; -1: kNeutralLook.
  bool dashed = false;  ///< All colours are taken: this one is taken a second time.
  bool operator==(const ObjectLook&) const = default;
};

inline LookColor ColorOf(const ObjectLook& look) {
  return look.color < 0 ? kNeutralLook
                        : kLookColors[static_cast<std::size_t>(look.color) % kLookColors.size()];
}

/// Of the objects that were ever confirmed.
using ObjectLooks = std::map<ObjectId, ObjectLook>;

}  // namespace plumbline
