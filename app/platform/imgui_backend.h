// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/platform/window.h"

namespace plumbline {

/// Dear ImGui's context, fed by the window and drawn into it. Input can be replaced between
/// TakeInput and ImGui::NewFrame.
class ImGuiBackend {
 public:
  explicit ImGuiBackend(PlatformWindow& window);
  ~ImGuiBackend();
  ImGuiBackend(const ImGuiBackend&) = delete;
  ImGuiBackend& operator=(const ImGuiBackend&) = delete;

  void TakeInput();
  /// After ImGui::Render.
  void Draw();
  /// Uploads the font atlas again after it has changed.
  void ReloadFonts();

 private:
  PlatformWindow& window_;
  double input_time_s_ = 0;
};

}  // namespace plumbline
