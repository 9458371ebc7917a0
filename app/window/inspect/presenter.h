// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "ui/framework/frame_context.h"
#include "ui/framework/panel.h"
#include "ui/framework/scene_surface.h"

namespace plumbline {

/// Shows a run on a projector: one view after the other, each with a caption, the map turning
/// slowly, for as long as nobody touches a key or a button. It shows whatever frame there is and
/// waits for nothing.
class Presenter {
 public:
  bool active() const { return active_; }
  std::size_t shot() const { return shot_; }
  /// Begins with the first view; plays in a loop.
  void Start(FrameContext& context, std::span<Panel* const> panels, CommandSink& sink);
  /// Leaves everything as it was found: frame, views, selection, panels.
  void Stop(FrameContext& context, std::span<Panel* const> panels, CommandSink& sink);
  /// Fills the window. True once the user wants to go on with something else.
  bool Draw(FrameContext& context, ImVec2 size, std::span<Panel* const> panels, CommandSink& sink);

 private:
  using Clock = std::chrono::steady_clock;
  /// The first view from `shot` on that has something to show.
  void Enter(std::size_t shot, FrameContext& context, std::span<Panel* const> panels);
  /// The frame that shows has nothing for this view: goes to one that has, or to the next view.
  void LeaveEmptiness(FrameContext& context, std::span<Panel* const> panels, CommandSink& sink);
  bool Touched();
  /// So that there are hypotheses to show.
  void SelectOneWithParticles(FrameContext& context) const;
  void DrawCaption(const FrameContext& context, ImVec2 low, ImVec2 high) const;

  bool active_ = false;
  bool armed_ = false;  ///< The key that started it is up again.
  std::size_t shot_ = 0;
  Clock::time_point entered_{}, sought_{};
  std::map<std::string, nlohmann::json> panel_states_;  ///< As they were before.
  bool look_through_ = false, follow_ = false, loop_ = false, played_ = false, mapped_on_ = false;
  int frame_ = 0;
  Selection selection_;
  ImageViewport viewport_;
  SceneCamera camera_;
};

}  // namespace plumbline
