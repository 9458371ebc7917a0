// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <deque>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include <imgui.h>
#include <nlohmann/json.hpp>

#include "engine/base/result.h"
#include "ui/framework/frame_context.h"

namespace plumbline {

/// Drives the real window from a file, for tests and pictures: `{"steps": [{"key": "space"},
/// ...]}`, one action after the other, at most one per window frame. docs/panels.md lists the
/// steps.
class UiScript {
 public:
  /// What a script can do besides input.
  struct Host {
    /// Of the whole window, or of the part that the widget `of` ("": all) fills.
    std::function<Status(const std::string& file, const std::string& of)> screenshot;
    std::function<nlohmann::json()> state;
    std::function<void(int width, int height)> resize;
    std::function<void(const std::string& name)> open;
    std::function<void(std::vector<std::string> files)> drop;
  };

  /// Errors: those of ReadScript.
  static Result<UiScript> Load(const std::filesystem::path& file);

  /// Before ImGui::NewFrame: replaces the user's input. `widgets` are those of the last frame.
  Status SetInput(const WidgetLog& widgets, ImGuiIO& io, const Host& host);
  /// After the frame is drawn, before it is swapped.
  Status AfterDraw(const Host& host);
  bool done() const { return actions_.empty() && steps_.empty(); }

 private:
  /// What one window frame does.
  struct Action {
    std::optional<ImVec2> mouse;
    std::optional<int> button_down, button_up;
    float wheel = 0;
    std::optional<int> key_down, key_up;
    bool shift = false, control = false, alt = false;
    std::string text;      ///< Typed.
    nlohmann::json after;  ///< A step that acts on the drawn frame.
  };

  Status Expand(const nlohmann::json& step, const WidgetLog& widgets, const Host& host);
  Status ExpandMouse(const nlohmann::json& step, const WidgetLog& widgets);
  Result<ImVec2> At(const std::string& name, double share_x, double share_y,
                    const WidgetLog& widgets) const;
  bool Waits(const nlohmann::json& step, const Host& host, Status& status);

  std::deque<nlohmann::json> steps_;
  std::deque<Action> actions_;
  Action current_;
  ImVec2 mouse_{-1, -1};
  bool buttons_[3] = {false, false, false};
  std::optional<int> held_key_;
  std::optional<std::chrono::steady_clock::time_point> waiting_since_;
};

}  // namespace plumbline
