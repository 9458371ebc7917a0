// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <optional>

#include <imgui.h>

#include "ui/framework/frame_context.h"
#include "ui/framework/mouse_drag.h"
#include "ui/framework/scene_surface.h"

namespace plumbline {

/// Turns, moves and zooms a 3-D view with the mouse over the last ImGui item: left drag turns,
/// right or middle drag or Shift moves, the wheel zooms to where the mouse is, a double click turns
/// about a point. A click, trembling or after a jump of the mouse, leaves the view as it is.
/// @param low   Top left of the view on the screen.
/// @param held  The left button does something else.
/// @return True while the view moves.
template <typename Surface>
bool MoveView(Surface& scene, ImVec2 low, bool held) {
  const ImGuiIO& io = ImGui::GetIO();
  const bool left = ImGui::IsMouseDown(ImGuiMouseButton_Left);
  const ImGuiMouseButton button = left ? ImGuiMouseButton_Left
                                  : ImGui::IsMouseDown(ImGuiMouseButton_Right)
                                      ? ImGuiMouseButton_Right
                                      : ImGuiMouseButton_Middle;
  const bool moving = ImGui::IsItemActive() && WasDragged(button);
  if (moving && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)) {
    if (left && !io.KeyShift && !io.KeyCtrl && !held) {
      scene.Orbit(io.MouseDelta.x, io.MouseDelta.y);
    } else if (!left || !held) {
      scene.Pan(io.MouseDelta.x, io.MouseDelta.y);
    }
  }
  if (!ImGui::IsItemHovered()) return moving;
  if (io.MouseWheel != 0) {
    // What is under the mouse, as far away as what the view turns about, stays under it.
    const ImVec2 end = ImGui::GetItemRectMax();
    const double grows = std::pow(kZoomPerNotch, -io.MouseWheel) - 1;
    scene.Zoom(io.MouseWheel);
    scene.Pan(-grows * (io.MousePos.x - 0.5 * (low.x + end.x)),
              -grows * (io.MousePos.y - 0.5 * (low.y + end.y)));
  }
  if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) && !held) {
    scene.FocusAt(io.MousePos.x - low.x, io.MousePos.y - low.y);
  }
  return moving;
}

/// Where on the screen the last item was clicked: the button was let go, without a drag, in this
/// frame, and went down there.
inline std::optional<ImVec2> ClickedAt(ImGuiMouseButton button = ImGuiMouseButton_Left) {
  const bool clicked = ImGui::IsItemHovered() && ImGui::IsItemDeactivated() &&
                       ImGui::IsMouseReleased(button) && !WasDragged(button);
  if (!clicked) return std::nullopt;
  return ImGui::GetIO().MouseClickedPos[button];
}

/// The directions of x, y and z, in the lower left corner.
void DrawTriad(const FrameContext& context, const Eigen::Matrix3d& view_from_world, ImVec2 low,
               ImVec2 high);

}  // namespace plumbline
