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
  /// Leaves everything as it was found.
  void Stop(FrameContext& context, std::span<Panel* const> panels, CommandSink& sink);
  /// Fills the window. True once the user wants to go on with something else.
  bool Draw(FrameContext& context, ImVec2 size, std::span<Panel* const> panels, CommandSink& sink);

 private:
  using Clock = std::chrono::steady_clock;
  void Enter(std::size_t shot, FrameContext& context, std::span<Panel* const> panels);
  bool Touched();
  void DrawCaption(const FrameContext& context, ImVec2 low, ImVec2 high) const;

  bool active_ = false;
  bool armed_ = false;  ///< The key that started it is up again.
  std::size_t shot_ = 0;
  Clock::time_point entered_{};
  std::map<std::string, nlohmann::json> panel_states_;  ///< As they were before.
  bool look_through_ = false, follow_ = false, loop_ = false, played_ = false;
  SceneCamera camera_;
};

}  // namespace plumbline
