// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/snapshot/commands.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Keys by the numbers that GLFW gives them.
namespace keys {
inline constexpr int kSpace = 32, kComma = 44, kMinus = 45, kPeriod = 46, kSlash = 47, kEqual = 61;
inline constexpr int kA = 65, kB = 66, kC = 67, kD = 68, kE = 69, kF = 70, kG = 71, kH = 72,
                     kI = 73, kK = 75, kL = 76, kM = 77, kN = 78, kO = 79, kP = 80, kQ = 81,
                     kR = 82, kS = 83, kT = 84, kV = 86, kW = 87, kX = 88, kY = 89, kZ = 90,
                     kLeftBracket = 91, kRightBracket = 93;
inline constexpr int kEscape = 256, kTab = 258, kBackspace = 259, kPageUp = 266, kPageDown = 267;
inline constexpr int kDelete = 261, kUp = 265, kDown = 264, kEnter = 257, kRight = 262, kLeft = 263,
                     kHome = 268, kEnd = 269;
inline constexpr int kPad0 = 320, kPad1 = 321, kPad2 = 322, kPad3 = 323, kPad4 = 324, kPad6 = 326,
                     kPad7 = 327, kPad8 = 328, kPad9 = 329, kPadPoint = 330, kPadMinus = 333,
                     kPadPlus = 334, kPadEnter = 335;
inline constexpr int kF1 = 290, kF5 = 294, kF11 = 300, kF12 = 301;
}  // namespace keys

struct KeyStroke {
  int key = 0;
  bool shift = false, control = false, alt = false;
  auto operator<=>(const KeyStroke&) const = default;
};
/// "Ctrl + Left"
std::string NameOf(const KeyStroke& stroke);
/// Number of a key by its name in scripts ("space", "left", "f12", "["); -1 if there is none.
int KeyByName(std::string_view name);

/// Something that the user can ask for, told once: keyboard, palette and help sheet follow it.
struct Action {
  std::string text;             ///< In the palette; "": not listed there.
  std::vector<KeyStroke> keys;  ///< Any of them does it.
  /// Empty: its workspace watches the keys itself (such as those that are held).
  std::function<void(const FrameContext& context, CommandSink& sink)> run;
  /// The row of the help sheet, which may tell of the actions that follow it, too; "": no row.
  std::string help_keys, help;
  /// Where it turns something on and off: how it is called while that is on, and whether it is.
  std::string text_when_on;
  std::function<bool(const FrameContext& context)> is_on;
  std::function<bool(const FrameContext& context)> is_offered;  ///< Empty: always.
  bool repeats = false;                                         ///< While the key is held.
};

/// Actions under one heading of the help sheet.
struct ActionGroup {
  std::string title;
  std::vector<Action> actions;
};

/// Does what the keys that went down in this ImGui frame stand for; nothing while text is typed or
/// a popup is open.
void RunKeys(std::span<const ActionGroup> groups, const FrameContext& context, CommandSink& sink);

/// Does what one command does: `Posts(StepCommand{1})`.
template <typename C>
std::function<void(const FrameContext&, CommandSink&)> Posts(C command) {
  return [command](const FrameContext&, CommandSink& sink) { sink.Post(command); };
}

}  // namespace plumbline
