// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <imgui.h>
#include <Eigen/Core>

#include "engine/snapshot/commands.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// The box as the engine knows it.
UprightBox InScan(const AnnotationSnapshot& snapshot, const LevelBox& box);
LevelBox InLevel(const AnnotationSnapshot& snapshot, const UprightBox& box);

/// Handles on the box that objects are cut out by: a disc on each side moves that side, the square
/// in the middle moves the box along the floor, the ring turns it about up.
class CropBoxHandles {
 public:
  /// After the view's item is made. True while a handle has the mouse, so that the view stays.
  bool Handle(const FrameContext& context, ImVec2 low);
  void Draw(const FrameContext& context, ImVec2 low, ImVec2 high) const;

 private:
  /// 0 .. 5: the sides -x, +x, -y, +y, -z, +z.
  static constexpr int kNone = -1, kMiddle = 6, kRing = 7;

  int HandleAt(const FrameContext& context, ImVec2 low) const;
  LevelBox Dragged(const FrameContext& context, ImVec2 low) const;

  int hovered_ = kNone, dragged_ = kNone;
  LevelBox start_;
  double grabbed_m_ = 0;              ///< Along the axis of a side.
  Eigen::Vector3d grabbed_{0, 0, 0};  ///< On the plane of the middle or the ring.
};

}  // namespace plumbline
