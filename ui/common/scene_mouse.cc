// SPDX-License-Identifier: Apache-2.0
#include "ui/common/scene_mouse.h"

#include <algorithm>

#include <Eigen/Core>

namespace plumbline {

void DrawTriad(const FrameContext& context, const Eigen::Matrix3d& view_from_world, ImVec2 low,
               ImVec2 high) {
  const float length = context.Scaled(26);
  const ImVec2 origin(low.x + context.Scaled(40), high.y - context.Scaled(40));
  constexpr ImU32 kColors[] = {IM_COL32(236, 92, 88, 255), IM_COL32(112, 200, 100, 255),
                               IM_COL32(92, 146, 246, 255)};
  constexpr const char* kNames[] = {"x", "y", "z"};
  int order[] = {0, 1, 2};
  std::sort(order, order + 3,
            [&](int a, int b) { return view_from_world(2, a) < view_from_world(2, b); });
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  for (const int axis : order) {
    const ImVec2 tip(origin.x + length * static_cast<float>(view_from_world(0, axis)),
                     origin.y - length * static_cast<float>(view_from_world(1, axis)));
    draw.AddLine(origin, tip, kColors[axis], context.Scaled(2));
    const ImVec2 at(origin.x + 1.35f * (tip.x - origin.x), origin.y + 1.35f * (tip.y - origin.y));
    const ImVec2 text =
        context.fonts.small->CalcTextSizeA(context.fonts.small->FontSize, 1e6f, 0, kNames[axis]);
    draw.AddText(context.fonts.small, context.fonts.small->FontSize,
                 {at.x - 0.5f * text.x, at.y - 0.5f * text.y}, kColors[axis], kNames[axis]);
  }
}

}  // namespace plumbline
