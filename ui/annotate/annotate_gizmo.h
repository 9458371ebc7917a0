// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <imgui.h>
#include <Eigen/Core>

#include "engine/snapshot/commands.h"
#include "ui/framework/annotate_view.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Handles on the selected object for exactly the ways in which it may move: dragging the object
/// itself moves it along the floor, the ring turns it, the arrow lifts it; two more rings tilt it
/// where that is unlocked. A drag is shown at once and becomes one edit when it ends.
class AnnotateGizmo {
 public:
  /// After the view's item is made. True while a handle has the mouse, so that the view stays.
  bool Handle(const FrameContext& context, ImVec2 low, CommandSink& sink);
  void Draw(const FrameContext& context, ImVec2 low, ImVec2 high) const;
  bool dragging() const { return dragged_ != Grip::kNone; }

 private:
  enum class Grip { kNone, kBody, kRing, kArrow, kTiltX, kTiltY };

  Grip GripAt(const FrameContext& context, ImVec2 low) const;
  Eigen::Isometry3d PoseAt(const FrameContext& context, ImVec2 low) const;

  Grip hovered_ = Grip::kNone, dragged_ = Grip::kNone;
  bool moved_ = false;                                       ///< Since it was grabbed.
  Eigen::Isometry3d start_ = Eigen::Isometry3d::Identity();  ///< In the scan.
  Eigen::Vector3d grabbed_{0, 0, 0};                         ///< In the level frame.
  ImVec2 grabbed_at_{0, 0};
};

}  // namespace plumbline
