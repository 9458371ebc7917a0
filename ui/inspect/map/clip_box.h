// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <imgui.h>

#include "ui/files/clip_box_json.h"
#include "ui/framework/frame_context.h"
#include "ui/framework/scene_surface.h"
#include "ui/inspect/map/scene_overlay.h"

namespace plumbline {

/// The box around everything that the map holds.
ClipBox ClipAround(const Eigen::AlignedBox3d& in_world, const Eigen::Vector3d& up_in_world);
/// The box around an object with half a metre of its surroundings; nothing for one whose shape has
/// no size.
std::optional<ClipBox> ClipAroundObject(const FrameContext& context, const ObjectReport& object);

/// The box that cuts the map, with a handle on each side that moves that side.
class ClipHandles {
 public:
  std::optional<ClipBox> box;

  /// After the view's item is made. True while a handle has the mouse, so that the view stays.
  bool Handle(const FrameContext& context, const SceneProjection& project);
  void Draw(const FrameContext& context, const SceneProjection& project, ImVec2 low,
            ImVec2 high) const;

 private:
  static constexpr int kNone = -1;
  int HandleAt(const FrameContext& context, const SceneProjection& project) const;

  int hovered_ = kNone, dragged_ = kNone;  ///< 0 .. 5: the sides -x, +x, -y, +y, bottom, top.
  ClipBox start_;
  double grabbed_m_ = 0;  ///< Along the axis of the side.
};

}  // namespace plumbline
