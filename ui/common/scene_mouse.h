// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <imgui.h>

#include "ui/framework/frame_context.h"

namespace plumbline {

/// Turns, moves and zooms a 3-D view with the mouse over the last ImGui item: left drag turns,
/// right or middle drag or Shift moves, the wheel zooms, a double click turns about a point.
/// @param low   Top left of the view on the screen.
/// @param held  The left button does something else.
/// @return True while the view moves.
template <typename Surface>
bool MoveView(Surface& scene, ImVec2 low, bool held) {
  const ImGuiIO& io = ImGui::GetIO();
  const bool moving = ImGui::IsItemActive() && (ImGui::IsMouseDragging(ImGuiMouseButton_Left, 1) ||
                                                ImGui::IsMouseDown(ImGuiMouseButton_Right) ||
                                                ImGui::IsMouseDown(ImGuiMouseButton_Middle));
  if (ImGui::IsItemActive() && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)) {
    const bool left = ImGui::IsMouseDown(ImGuiMouseButton_Left);
    if (left && !io.KeyShift && !io.KeyCtrl && !held) {
      scene.Orbit(io.MouseDelta.x, io.MouseDelta.y);
    } else if (!left || !held) {
      scene.Pan(io.MouseDelta.x, io.MouseDelta.y);
    }
  }
  if (!ImGui::IsItemHovered()) return moving;
  if (io.MouseWheel != 0) scene.Zoom(io.MouseWheel);
  if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) && !held) {
    scene.FocusAt(io.MousePos.x - low.x, io.MousePos.y - low.y);
  }
  return moving;
}

/// Whether the left button was let go over the last item without a drag.
inline bool WasClicked() {
  if (!ImGui::IsItemHovered() || !ImGui::IsItemDeactivated() ||
      !ImGui::IsMouseReleased(ImGuiMouseButton_Left)) {
    return false;
  }
  const ImVec2 dragged = ImGui::GetMouseDragDelta(ImGuiMouseButton_Left, 0);
  return dragged.x == 0 && dragged.y == 0;
}

/// The directions of x, y and z, in the lower left corner.
void DrawTriad(const FrameContext& context, const Eigen::Matrix3d& view_from_world, ImVec2 low,
               ImVec2 high);

}  // namespace plumbline
