// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string_view>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Keys by the numbers that GLFW gives them.
namespace keys {
inline constexpr int kSpace = 32, kComma = 44, kMinus = 45, kPeriod = 46, kSlash = 47, kEqual = 61;
inline constexpr int kA = 65, kB = 66, kC = 67, kD = 68, kE = 69, kF = 70, kG = 71, kH = 72,
                     kI = 73, kL = 76, kN = 78, kO = 79, kP = 80, kQ = 81, kR = 82, kS = 83,
                     kT = 84, kV = 86, kW = 87, kX = 88, kY = 89, kZ = 90, kLeftBracket = 91,
                     kRightBracket = 93;
inline constexpr int kEscape = 256, kDelete = 261, kUp = 265, kDown = 264, kEnter = 257,
                     kRight = 262, kLeft = 263, kHome = 268, kEnd = 269;
inline constexpr int kF1 = 290, kF5 = 294, kF12 = 301;
}  // namespace keys

/// One row of the table that drives both the keyboard and the help sheet.
struct Shortcut {
  int key = 0;
  bool shift = false, control = false;
  const char* keys = "";  ///< As the help sheet shows it; "" for an alias of the row before.
  const char* meaning = "";
  const char* group = "";
};
std::span<const Shortcut> Shortcuts();

/// Number of a key by its name in scripts ("space", "left", "f12", "["); -1 if there is none.
int KeyByName(std::string_view name);

/// Directions from which the map is looked at, by digits.
struct AxisView {
  char key;
  const char* name;
  double azimuth_rad, elevation_rad;
};
std::span<const AxisView> AxisViews();

/// Playback speeds that [ and ] walk through; 0 is as fast as it goes.
std::span<const double> PlaybackSpeeds();

/// Posts the commands of the keys that went down in this ImGui frame. `help_shown`: Esc closes the
/// sheet first.
void PostShortcuts(const FrameContext& context, bool help_shown, CommandSink& sink);

}  // namespace plumbline
