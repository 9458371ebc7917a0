// SPDX-License-Identifier: Apache-2.0
#include "ui/inspect/map/clip_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "engine/geometry/gravity.h"
#include "engine/snapshot/map_snapshot.h"
#include "ui/framework/mouse_drag.h"
#include "ui/framework/sight_line.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr double kMargin_m = 0.1, kObjectMargin_m = 0.5, kLeast_m = 0.1;
constexpr double kHandleReach_px = 10, kHandle_px = 6, kEndOn_px = 8;
constexpr ImU32 kSideColors[] = {IM_COL32(236, 92, 88, 255), IM_COL32(112, 200, 100, 255),
                                 IM_COL32(92, 146, 246, 255)};
constexpr const char* kSideNames[] = {"scene.clip.x0", "scene.clip.x1",     "scene.clip.y0",
                                      "scene.clip.y1", "scene.clip.bottom", "scene.clip.top"};

/// The middle of a side, in world.
Vector3d SideOf(const ClipBox& box, int side) {
  Vector3d middle = box.in_upright.center();
  middle[side / 2] =
      side % 2 == 0 ? box.in_upright.min()[side / 2] : box.in_upright.max()[side / 2];
  return box.world_from_upright * middle;
}

/// Nothing where it is behind the eye or its axis is seen end on.
std::optional<ImVec2> SideOnScreen(const FrameContext& context, const SceneProjection& project,
                                   const ClipBox& box, int side) {
  const Vector3d middle = SideOf(box, side);
  const auto here = project(middle);
  const auto beyond = project(middle + 0.2 * box.world_from_upright.col(side / 2));
  if (!here || !beyond) return std::nullopt;
  const bool end_on =
      std::hypot(beyond->x - here->x, beyond->y - here->y) < context.Scaled(kEndOn_px);
  return end_on ? std::nullopt : here;
}

/// Around points of the world, in the upright frame, with a margin.
template <typename Points>
ClipBox Around(const Points& points_in_world, const Vector3d& up_in_world, double margin_m) {
  ClipBox box;
  box.world_from_upright = UprightFrame(-up_in_world).upright_rotation();
  box.in_upright.setEmpty();
  for (const Vector3d& point : points_in_world)
    box.in_upright.extend(Vector3d(box.world_from_upright.transpose() * point));
  box.in_upright.min().array() -= margin_m;
  box.in_upright.max().array() += margin_m;
  return box;
}

std::array<Vector3d, 8> CornersOf(const Eigen::AlignedBox3d& box) {
  std::array<Vector3d, 8> corners;
  for (int i = 0; i < 8; ++i)
    corners[static_cast<std::size_t>(i)] =
        box.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
  return corners;
}

}  // namespace

ClipBox ClipAround(const Eigen::AlignedBox3d& in_world, const Vector3d& up_in_world) {
  return Around(CornersOf(in_world), up_in_world, kMargin_m);
}

std::optional<ClipBox> ClipAroundObject(const FrameContext& context, const ObjectReport& object) {
  const ModelView* model = context.Model(object.label);
  if (model == nullptr || model->bounds.isEmpty()) return std::nullopt;
  auto corners = CornersOf(model->bounds.cast<double>());
  for (Vector3d& corner : corners) corner = object.world_from_object * (object.scale * corner);
  return Around(corners, context.sequence->up_in_world, kObjectMargin_m);
}

int ClipHandles::HandleAt(const FrameContext& context, const SceneProjection& project) const {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  int nearest = kNone;
  double least = context.Scaled(kHandleReach_px);
  for (int side = 0; side < 6; ++side) {
    const auto at = SideOnScreen(context, project, *box, side);
    const double distance = at ? std::hypot(at->x - mouse.x, at->y - mouse.y) : 1e9;
    if (distance >= least) continue;
    least = distance;
    nearest = side;
  }
  return nearest;
}

bool ClipHandles::Handle(const FrameContext& context, const SceneProjection& project) {
  if (!box) {
    hovered_ = dragged_ = kNone;
    return false;
  }
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  if (dragged_ != kNone) {
    const int axis = dragged_ / 2;
    if (!ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
      dragged_ = kNone;
    } else if (WasDragged(ImGuiMouseButton_Left)) {
      const double by = AlongAxisNear(project.Sight(mouse), SideOf(start_, dragged_),
                                      start_.world_from_upright.col(axis)) -
                        grabbed_m_;
      *box = start_;
      if (dragged_ % 2 == 0)
        box->in_upright.min()[axis] =
            std::min(start_.in_upright.min()[axis] + by, start_.in_upright.max()[axis] - kLeast_m);
      else
        box->in_upright.max()[axis] =
            std::max(start_.in_upright.max()[axis] + by, start_.in_upright.min()[axis] + kLeast_m);
    }
    return true;
  }
  hovered_ = ImGui::IsItemHovered() ? HandleAt(context, project) : kNone;
  const bool pressed = ImGui::IsItemActivated() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
  if (!pressed || hovered_ == kNone || ImGui::GetIO().KeyShift) return false;
  dragged_ = hovered_;
  start_ = *box;
  grabbed_m_ = AlongAxisNear(project.Sight(mouse), SideOf(start_, dragged_),
                             start_.world_from_upright.col(dragged_ / 2));
  return true;
}

void ClipHandles::Draw(const FrameContext& context, const SceneProjection& project, ImVec2 low,
                       ImVec2 high) const {
  if (!box) return;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect(low, high, true);
  std::array<std::optional<ImVec2>, 8> corners;
  for (std::size_t i = 0; i < 8; ++i)
    corners[i] = project(box->world_from_upright *
                         box->in_upright.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i)));
  for (std::size_t i = 0; i < 8; ++i) {
    for (const std::size_t bit : {1u, 2u, 4u}) {
      const std::size_t j = i | bit;
      if (j == i || !corners[i] || !corners[j]) continue;
      draw.AddLine(*corners[i], *corners[j], colors::kAccent, context.Scaled(1.5));
    }
  }
  const int active = dragged_ != kNone ? dragged_ : hovered_;
  for (int side = 0; side < 6; ++side) {
    const auto at = SideOnScreen(context, project, *box, side);
    if (!at) continue;
    const float size = context.Scaled(active == side ? kHandle_px + 2 : kHandle_px);
    draw.AddCircleFilled(*at, size, kSideColors[side / 2]);
    draw.AddCircle(*at, size, IM_COL32(0, 0, 0, 170));
    context.widgets->Add(kSideNames[side], {at->x - size, at->y - size},
                         {at->x + size, at->y + size});
  }
  draw.PopClipRect();
}

}  // namespace plumbline
