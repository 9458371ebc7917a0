// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_crop_box.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "engine/geometry/gravity.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/scene_geometry.h"
#include "ui/framework/mouse_drag.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

using Eigen::Vector3d;

constexpr double kReach_px = 9, kDisc_px = 6, kShortest_px = 10;
constexpr double kLeast_m = 0.04;  ///< Of a side.
constexpr int kSegments = 72;
constexpr ImU32 kAxisColors[] = {IM_COL32(236, 92, 88, 255), IM_COL32(112, 200, 100, 255),
                                 IM_COL32(92, 146, 246, 255)};
constexpr ImU32 kRingColor = kAxisColors[2], kMiddleColor = IM_COL32(240, 240, 240, 255);
constexpr const char* kNames[] = {"back", "front", "right", "left", "bottom", "top", "middle"};

Vector3d AxisOf(const LevelBox& box, int axis) {
  if (axis == 2) return Vector3d::UnitZ();
  const double angle = box.azimuth_rad + (axis == 0 ? 0 : 0.5 * std::numbers::pi);
  return {std::cos(angle), std::sin(angle), 0};
}

Vector3d SideAt(const LevelBox& box, int side) {
  const double sign = side % 2 == 0 ? -0.5 : 0.5;
  return box.center + sign * box.size_m[side / 2] * AxisOf(box, side / 2);
}

/// Where a handle is on the screen; nothing behind the eye, or where its axis is seen end on.
std::optional<ImVec2> HandleOnScreen(const FrameContext& context, ImVec2 low, const LevelBox& box,
                                     int handle) {
  const auto at = [&](const Vector3d& point) {
    return ScreenOf(*context.annotate_scene, low, point);
  };
  if (handle > 5) return at(box.center);
  const Vector3d side = SideAt(box, handle);
  const auto here = at(side);
  const auto beyond = at(side + 0.2 * AxisOf(box, handle / 2));
  if (!here || !beyond) return std::nullopt;
  const bool end_on =
      std::hypot(beyond->x - here->x, beyond->y - here->y) < context.Scaled(kShortest_px);
  return end_on ? std::nullopt : here;
}

double RadiusOf(const LevelBox& box) { return 0.5 * box.size_m.head<2>().norm() + 0.08; }

std::vector<ImVec2> Ring(const FrameContext& context, ImVec2 low, const LevelBox& box) {
  const Vector3d foot = box.center - 0.5 * box.size_m.z() * Vector3d::UnitZ();
  std::vector<ImVec2> points;
  for (int i = 0; i <= kSegments; ++i) {
    const double angle = 2 * std::numbers::pi * i / kSegments;
    const Vector3d at = foot + RadiusOf(box) * Vector3d(std::cos(angle), std::sin(angle), 0);
    const auto seen = ScreenOf(*context.annotate_scene, low, at);
    if (!seen) return {};
    points.push_back(*seen);
  }
  return points;
}

}  // namespace

UprightBox InScan(const AnnotationSnapshot& snapshot, const LevelBox& box) {
  return {snapshot.level_from_scan.inverse() * box.center, box.size_m, box.azimuth_rad};
}

LevelBox InLevel(const AnnotationSnapshot& snapshot, const UprightBox& box) {
  return {snapshot.level_from_scan * box.center_in_scan, box.size_m, box.azimuth_rad};
}

int CropBoxHandles::HandleAt(const FrameContext& context, ImVec2 low) const {
  const LevelBox& box = *context.annotate->crop_box;
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  int nearest = kNone;
  double least = context.Scaled(kReach_px);
  for (int handle = 0; handle <= kMiddle; ++handle) {
    const auto at = HandleOnScreen(context, low, box, handle);
    const double distance = at ? std::hypot(at->x - mouse.x, at->y - mouse.y) : 1e9;
    if (distance >= least) continue;
    least = distance;
    nearest = handle;
  }
  if (nearest != kNone) return nearest;
  const bool on_ring = DistanceTo(Ring(context, low, box), mouse) < context.Scaled(kReach_px);
  return on_ring ? kRing : kNone;
}

LevelBox CropBoxHandles::Dragged(const FrameContext& context, ImVec2 low) const {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const SightLine sight = context.annotate_scene->Sight(mouse.x - low.x, mouse.y - low.y);
  LevelBox box = start_;
  if (dragged_ == kMiddle || dragged_ == kRing) {
    const auto now = OnPlane(sight, grabbed_, Vector3d::UnitZ());
    if (!now) return box;
    if (dragged_ == kMiddle) {
      box.center += *now - grabbed_;
      box.center.z() = start_.center.z();
    } else {
      const Vector3d u = grabbed_ - start_.center, v = *now - start_.center;
      box.azimuth_rad =
          WrapAngle(start_.azimuth_rad + std::atan2(v.y(), v.x()) - std::atan2(u.y(), u.x()));
    }
    return box;
  }
  const int axis = dragged_ / 2;
  const double sign = dragged_ % 2 == 0 ? -1 : 1;
  const Vector3d along = AxisOf(start_, axis);
  const double by = sign * (AlongAxisNear(sight, SideAt(start_, dragged_), along) - grabbed_m_);
  box.size_m[axis] = std::max(kLeast_m, start_.size_m[axis] + by);
  box.center += 0.5 * sign * (box.size_m[axis] - start_.size_m[axis]) * along;
  return box;
}

bool CropBoxHandles::Handle(const FrameContext& context, ImVec2 low) {
  AnnotateView& view = *context.annotate;
  if (!view.crop_box || view.tool != AnnotateTool::kCut) {
    hovered_ = dragged_ = kNone;
    return false;
  }
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  if (dragged_ != kNone) {
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
      if (WasDragged(ImGuiMouseButton_Left)) view.crop_box = Dragged(context, low);
    } else {
      dragged_ = kNone;
    }
    return true;
  }
  hovered_ = ImGui::IsItemHovered() ? HandleAt(context, low) : kNone;
  const bool pressed = ImGui::IsItemActivated() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
  if (!pressed || hovered_ == kNone || ImGui::GetIO().KeyShift) return false;
  dragged_ = hovered_;
  start_ = *view.crop_box;
  const SightLine sight = context.annotate_scene->Sight(mouse.x - low.x, mouse.y - low.y);
  if (dragged_ < kMiddle) {
    grabbed_m_ = AlongAxisNear(sight, SideAt(start_, dragged_), AxisOf(start_, dragged_ / 2));
  } else {
    Vector3d level = start_.center;
    if (dragged_ == kRing) level.z() -= 0.5 * start_.size_m.z();
    grabbed_ = OnPlane(sight, level, Vector3d::UnitZ()).value_or(level);
  }
  return true;
}

void CropBoxHandles::Draw(const FrameContext& context, ImVec2 low, ImVec2 high) const {
  const AnnotateView& view = *context.annotate;
  if (!view.crop_box || view.tool != AnnotateTool::kCut) return;
  const LevelBox& box = *view.crop_box;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect(low, high, true);
  const int active = dragged_ != kNone ? dragged_ : hovered_;
  std::optional<ImVec2> corners[8];
  for (int i = 0; i < 8; ++i) {
    Vector3d corner = box.center;
    for (int axis = 0; axis < 3; ++axis) {
      corner += ((i >> axis & 1) - 0.5) * box.size_m[axis] * AxisOf(box, axis);
    }
    corners[i] = ScreenOf(*context.annotate_scene, low, corner);
  }
  for (int i = 0; i < 8; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      const int other = i | 1 << axis;
      if (other == i || !corners[i] || !corners[other]) continue;
      draw.AddLine(*corners[i], *corners[other], colors::kAccent, context.Scaled(1.5));
    }
  }
  const std::vector<ImVec2> ring = Ring(context, low, box);
  draw.AddPolyline(ring.data(), static_cast<int>(ring.size()),
                   WithAlpha(kRingColor, active == kRing ? 1.0 : 0.7), 0,
                   context.Scaled(active == kRing ? 4 : 2.5));
  const Vector3d foot = box.center - 0.5 * box.size_m.z() * Vector3d::UnitZ();
  const auto front = ScreenOf(*context.annotate_scene, low, foot + RadiusOf(box) * AxisOf(box, 0));
  if (front) {
    draw.AddCircleFilled(*front, context.Scaled(5), kRingColor);
    LogRect(context, "crop.handle.ring", *front, context.Scaled(kDisc_px));
  }
  for (int handle = 0; handle <= kMiddle; ++handle) {
    const auto at = HandleOnScreen(context, low, box, handle);
    if (!at) continue;
    const float size = context.Scaled(active == handle ? kDisc_px + 2 : kDisc_px);
    const ImU32 dark = IM_COL32(0, 0, 0, 170);
    if (handle == kMiddle) {
      draw.AddRectFilled({at->x - size, at->y - size}, {at->x + size, at->y + size}, kMiddleColor,
                         context.Scaled(2));
      draw.AddRect({at->x - size, at->y - size}, {at->x + size, at->y + size}, dark,
                   context.Scaled(2));
    } else {
      draw.AddCircleFilled(*at, size, kAxisColors[handle / 2]);
      draw.AddCircle(*at, size, dark);
    }
    LogRect(context, std::string("crop.handle.") + kNames[handle], *at, context.Scaled(kDisc_px));
  }
  draw.PopClipRect();
}

}  // namespace plumbline
