// SPDX-License-Identifier: Apache-2.0
#include "ui/annotate/annotate_gizmo.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "ui/annotate/annotate_edits.h"
#include "ui/annotate/annotate_pose.h"
#include "ui/annotate/scene_geometry.h"
#include "ui/framework/mouse_drag.h"
#include "ui/framework/widgets.h"

namespace plumbline {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kGripReach_px = 8, kShortestArrow_px = 14;
constexpr int kRingSegments = 72;
constexpr double kTurnPerPixel = 0.008;
constexpr ImU32 kGizmoRingColor = IM_COL32(92, 146, 246, 255),
                kArrowColor = IM_COL32(120, 220, 250, 255),
                kTiltXColor = IM_COL32(236, 92, 88, 255),
                kTiltYColor = IM_COL32(112, 200, 100, 255);

/// The selected object and the size of its handles, in the level frame.
struct Subject {
  const AnnotatedInstance* instance = nullptr;
  Isometry3d pose = Isometry3d::Identity();  ///< level_from_object
  double radius_m = 0.5, height_m = 1;
};

std::optional<Subject> SubjectOf(const FrameContext& context) {
  const AnnotationSnapshot& snapshot = *context.annotation;
  const AnnotatedInstance* instance = snapshot.Selected();
  if (instance == nullptr || instance->hidden || instance->locked || snapshot.read_only) {
    return std::nullopt;
  }
  if (snapshot.placement || snapshot.floor || snapshot.refinement) return std::nullopt;
  const AnnotationModel* model = snapshot.ModelOf(*instance);
  if (model == nullptr) return std::nullopt;
  Subject subject;
  subject.instance = instance;
  const auto& pending = context.annotate->pending;
  subject.pose = snapshot.level_from_scan * (pending && pending->id == instance->id
                                                 ? pending->scan_from_object
                                                 : instance->scan_from_object);
  const Eigen::Vector3d size = model->bounds.sizes().cast<double>();
  subject.radius_m = 0.5 * size.head<2>().norm() + 0.08;
  subject.height_m = model->bounds.max().z() + 0.25 * size.z() + 0.1;
  return subject;
}

/// A circle about `axis` through the origin of the subject, on the screen.
std::vector<ImVec2> Ring(const FrameContext& context, ImVec2 low, const Subject& subject,
                         int axis) {
  std::vector<ImVec2> points;
  const Vector3d center = subject.pose.translation();
  const Vector3d a = Vector3d::Unit((axis + 1) % 3), b = Vector3d::Unit((axis + 2) % 3);
  for (int i = 0; i <= kRingSegments; ++i) {
    const double angle = 2 * std::numbers::pi * i / kRingSegments;
    const auto at =
        ScreenOf(*context.annotate_scene, low,
                 center + subject.radius_m * (std::cos(angle) * a + std::sin(angle) * b));
    if (!at) return {};
    points.push_back(*at);
  }
  return points;
}

/// The part of the upright line that is the arrow; nothing where it is seen end on.
std::optional<std::pair<ImVec2, ImVec2>> Arrow(const FrameContext& context, ImVec2 low,
                                               const Subject& subject) {
  const Vector3d foot = subject.pose.translation();
  const auto a =
      ScreenOf(*context.annotate_scene, low, foot + 0.75 * subject.height_m * Vector3d::UnitZ());
  const auto b =
      ScreenOf(*context.annotate_scene, low, foot + subject.height_m * Vector3d::UnitZ());
  if (!a || !b || std::hypot(b->x - a->x, b->y - a->y) < context.Scaled(kShortestArrow_px)) {
    return std::nullopt;
  }
  return std::pair(*a, *b);
}

SightLine SightAtMouse(const FrameContext& context, ImVec2 low) {
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  return context.annotate_scene->Sight(mouse.x - low.x, mouse.y - low.y);
}

}  // namespace

AnnotateGizmo::Grip AnnotateGizmo::GripAt(const FrameContext& context, ImVec2 low) const {
  const auto subject = SubjectOf(context);
  if (!subject || context.annotate->tool != AnnotateTool::kSelect) return Grip::kNone;
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  const double reach = context.Scaled(kGripReach_px);
  const auto arrow = Arrow(context, low, *subject);
  if (arrow && DistanceToLine(mouse, arrow->first, arrow->second) < reach) return Grip::kArrow;
  if (DistanceTo(Ring(context, low, *subject, 2), mouse) < reach) return Grip::kRing;
  if (subject->instance->may_tilt) {
    if (DistanceTo(Ring(context, low, *subject, 0), mouse) < reach) return Grip::kTiltX;
    if (DistanceTo(Ring(context, low, *subject, 1), mouse) < reach) return Grip::kTiltY;
  }
  const bool on_body = context.annotate_scene->PickInstance(mouse.x - low.x, mouse.y - low.y) ==
                       subject->instance->id;
  return on_body ? Grip::kBody : Grip::kNone;
}

Isometry3d AnnotateGizmo::PoseAt(const FrameContext& context, ImVec2 low) const {
  const AnnotationSnapshot& snapshot = *context.annotation;
  const SightLine sight = SightAtMouse(context, low);
  const Vector3d origin = snapshot.level_from_scan * start_.translation();
  const ImVec2 mouse = ImGui::GetIO().MousePos;
  if (dragged_ == Grip::kBody) {
    const auto now = OnPlane(sight, grabbed_, Vector3d::UnitZ());
    if (!now) return start_;
    const Vector3d by = *now - grabbed_;
    return Moved(snapshot, start_, {by.x(), by.y(), 0});
  }
  if (dragged_ == Grip::kArrow) {
    return Moved(
        snapshot, start_,
        {0, 0, origin.z() + AlongAxisNear(sight, origin, Vector3d::UnitZ()) - grabbed_.z()});
  }
  const int axis = dragged_ == Grip::kRing ? 2 : dragged_ == Grip::kTiltX ? 0 : 1;
  const Vector3d normal = Vector3d::Unit(axis);
  const auto now = OnPlane(sight, origin, normal);
  double angle = kTurnPerPixel * (mouse.x - grabbed_at_.x);
  if (now) {
    const Vector3d u = grabbed_ - origin, v = *now - origin;
    angle = std::atan2(normal.dot(u.cross(v)), u.dot(v));
  }
  return Turned(snapshot, start_, normal, angle);
}

bool AnnotateGizmo::Handle(const FrameContext& context, ImVec2 low, CommandSink& sink) {
  AnnotateView& view = *context.annotate;
  const AnnotatedInstance* selected = context.annotation->Selected();
  if (dragged_ == Grip::kNone) {
    const bool over = ImGui::IsItemHovered() && !ImGui::IsMouseDown(ImGuiMouseButton_Right);
    const bool pressed = ImGui::IsItemActivated() && ImGui::IsMouseDown(ImGuiMouseButton_Left);
    // What lies under the mouse is asked for while it rests or as it goes down, not while it turns.
    const ImVec2 moved = ImGui::GetIO().MouseDelta;
    const bool looks = pressed || (!ImGui::IsItemActive() && (moved.x != 0 || moved.y != 0));
    if (over && looks) hovered_ = GripAt(context, low);
    if (!over) hovered_ = Grip::kNone;
    // Which then add to the selection, or move the view.
    const bool elsewhere = ImGui::GetIO().KeyShift || ImGui::GetIO().KeyCtrl || view.boxing;
    if (!pressed || hovered_ == Grip::kNone || elsewhere) return false;
    const auto subject = SubjectOf(context);
    dragged_ = hovered_;
    // From where it is shown: a pose may be on its way.
    const bool on_its_way = view.pending && view.pending->id == subject->instance->id;
    start_ = on_its_way ? view.pending->scan_from_object : subject->instance->scan_from_object;
    moved_ = false;
    grabbed_at_ = ImGui::GetIO().MousePos;
    const SightLine sight = SightAtMouse(context, low);
    const Vector3d origin = subject->pose.translation();
    grabbed_ = origin;
    if (dragged_ == Grip::kArrow) {
      grabbed_.z() = origin.z() + AlongAxisNear(sight, origin, Vector3d::UnitZ());
    } else if (dragged_ == Grip::kBody) {
      const auto on_scan =
          OnPlane(sight, origin + 0.5 * subject->height_m * Vector3d::UnitZ(), Vector3d::UnitZ());
      grabbed_ = on_scan.value_or(origin);
    } else {
      const int axis = dragged_ == Grip::kRing ? 2 : dragged_ == Grip::kTiltX ? 0 : 1;
      grabbed_ = OnPlane(sight, origin, Vector3d::Unit(axis)).value_or(origin);
    }
    return true;
  }
  if (selected == nullptr || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape))) {
    view.pending.reset();
    dragged_ = Grip::kNone;
  } else if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
    moved_ = moved_ || WasDragged(ImGuiMouseButton_Left);
    if (moved_) view.pending = OnItsWay(context, *selected, PoseAt(context, low));
  } else {
    // Shown until the snapshot has it.
    if (moved_ && view.pending) sink.Post(EditOf(*view.pending));
    dragged_ = Grip::kNone;
  }
  return true;
}

void AnnotateGizmo::Draw(const FrameContext& context, ImVec2 low, ImVec2 high) const {
  const auto subject = SubjectOf(context);
  if (!subject || context.annotate->tool != AnnotateTool::kSelect) return;
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect(low, high, true);
  const Grip active = dragged_ != Grip::kNone ? dragged_ : hovered_;
  const auto line = [&](const std::vector<ImVec2>& points, ImU32 color, Grip grip) {
    draw.AddPolyline(points.data(), static_cast<int>(points.size()),
                     WithAlpha(active == grip ? Mixed(color, IM_COL32_WHITE, 0.5) : color,
                               active == grip ? 1.0 : 0.75),
                     0, context.Scaled(active == grip ? 4 : 2.5));
  };
  line(Ring(context, low, *subject, 2), kGizmoRingColor, Grip::kRing);
  if (subject->instance->may_tilt) {
    line(Ring(context, low, *subject, 0), kTiltXColor, Grip::kTiltX);
    line(Ring(context, low, *subject, 1), kTiltYColor, Grip::kTiltY);
  }
  const Vector3d foot = subject->pose.translation();
  // The front: where the ring is grabbed is as good as any place, but this one tells the azimuth.
  const auto front = ScreenOf(*context.annotate_scene, low,
                              foot + subject->radius_m * subject->pose.linear().col(0));
  if (front) draw.AddCircleFilled(*front, context.Scaled(5), kGizmoRingColor);
  if (const auto arrow = Arrow(context, low, *subject)) {
    const ImVec2& tip = arrow->second;
    line({arrow->first, tip}, kArrowColor, Grip::kArrow);
    const float size = context.Scaled(7);
    draw.AddTriangleFilled({tip.x - size, tip.y + 0.4f * size}, {tip.x + size, tip.y + 0.4f * size},
                           {tip.x, tip.y - 1.3f * size}, kArrowColor);
  }
  if (dragged_ != Grip::kNone && context.annotate->pending) {
    const LevelPose before = ReadPose(*context.annotation, start_);
    const LevelPose now =
        ReadPose(*context.annotation, context.annotate->pending->scan_from_object);
    const double turned = WrapAngle(now.azimuth_rad - before.azimuth_rad) * kDegreesPerRadian;
    const std::string text =
        dragged_ == Grip::kBody
            ? fmt::format("{:.1f} cm", 100 * std::hypot(now.x - before.x, now.y - before.y))
        : dragged_ == Grip::kArrow ? fmt::format("{:+.1f} cm up", 100 * (now.z - before.z))
        : dragged_ == Grip::kRing
            ? fmt::format("{:+.1f}\u00b0", turned)
            : fmt::format("tilt {:.1f}\u00b0", now.tilt_rad * kDegreesPerRadian);
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    PictureLabels labels(context, low, high);
    labels.Add({{mouse.x + context.Scaled(16), mouse.y - context.Scaled(10)}}, colors::kOnPicture,
               text);
  }
  draw.PopClipRect();
}

}  // namespace plumbline
