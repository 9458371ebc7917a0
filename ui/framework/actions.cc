// SPDX-License-Identifier: Apache-2.0
#include "ui/framework/actions.h"

#include <cctype>
#include <map>

namespace plumbline {
namespace {

const std::map<std::string_view, int>& KeyNames() {
  static const std::map<std::string_view, int> kNames = {{"space", keys::kSpace},
                                                         {"left", keys::kLeft},
                                                         {"right", keys::kRight},
                                                         {"enter", keys::kEnter},
                                                         {"up", keys::kUp},
                                                         {"down", keys::kDown},
                                                         {"delete", keys::kDelete},
                                                         {"home", keys::kHome},
                                                         {"end", keys::kEnd},
                                                         {"escape", keys::kEscape},
                                                         {"f1", keys::kF1},
                                                         {"f5", keys::kF5},
                                                         {"tab", keys::kTab},
                                                         {"f12", keys::kF12},
                                                         {"[", keys::kLeftBracket},
                                                         {"]", keys::kRightBracket},
                                                         {"/", keys::kSlash},
                                                         {",", keys::kComma},
                                                         {".", keys::kPeriod},
                                                         {"=", keys::kEqual},
                                                         {"-", keys::kMinus},
                                                         {"pad0", keys::kPad0},
                                                         {"pad1", keys::kPad1},
                                                         {"pad3", keys::kPad3},
                                                         {"pad7", keys::kPad7},
                                                         {"pad.", keys::kPadPoint},
                                                         {"padenter", keys::kPadEnter},
                                                         {"pad2", keys::kPad2},
                                                         {"pad4", keys::kPad4},
                                                         {"pad6", keys::kPad6},
                                                         {"pad8", keys::kPad8},
                                                         {"pad9", keys::kPad9},
                                                         {"pad+", keys::kPadPlus},
                                                         {"pad-", keys::kPadMinus},
                                                         {"f11", keys::kF11},
                                                         {"backspace", keys::kBackspace},
                                                         {"page up", keys::kPageUp},
                                                         {"page down", keys::kPageDown}};
  return kNames;
}

std::string NameOf(int key) {
  for (const auto& [name, number] : KeyNames()) {
    if (number != key) continue;
    std::string capital(name);
    capital[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(capital[0])));
    return capital;
  }
  return std::string(1, static_cast<char>(key));
}

}  // namespace

std::string NameOf(const KeyStroke& stroke) {
  return std::string(stroke.control ? "Ctrl + " : "") + (stroke.shift ? "Shift + " : "") +
         (stroke.alt ? "Alt + " : "") + NameOf(stroke.key);
}

int KeyByName(std::string_view name) {
  if (name == "?") return keys::kSlash;  // with Shift
  if (const auto found = KeyNames().find(name); found != KeyNames().end()) return found->second;
  if (name.size() == 1 && std::isalnum(static_cast<unsigned char>(name[0]))) {
    return std::toupper(static_cast<unsigned char>(name[0]));
  }
  return -1;
}

void RunKeys(std::span<const ActionGroup> groups, const FrameContext& context, CommandSink& sink) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopupId)) return;
  for (const ActionGroup& group : groups) {
    for (const Action& action : group.actions) {
      if (!action.run || (action.is_offered && !action.is_offered(context))) continue;
      for (const KeyStroke& stroke : action.keys) {
        if (stroke.shift == io.KeyShift && stroke.control == io.KeyCtrl &&
            stroke.alt == io.KeyAlt && ImGui::IsKeyPressed(stroke.key, action.repeats))
          action.run(context, sink);
      }
    }
  }
}

}  // namespace plumbline
