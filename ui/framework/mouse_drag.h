// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <imgui.h>

namespace plumbline {

/// Hands tremble: a button that goes up no farther than this from where it went down has clicked.
inline constexpr float kTremor_px = 4;

/// Whether the mouse has been dragged since the button went down, be it held still or up again in
/// this frame.
inline bool WasDragged(ImGuiMouseButton button) {
  return ImGui::GetIO().MouseDragMaxDistanceSqr[button] > kTremor_px * kTremor_px;
}

}  // namespace plumbline
