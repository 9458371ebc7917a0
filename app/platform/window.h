// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <opencv2/core.hpp>

#include "app/platform/input_queue.h"
#include "engine/base/result.h"

struct GLFWwindow;

namespace plumbline {

/// The one window, with an OpenGL core context that is current in the thread that made it.
class PlatformWindow {
 public:
  /// Errors: kUnsupported when there is no display or no OpenGL 3.3.
  static Result<std::unique_ptr<PlatformWindow>> Open(const std::string& title, int width,
                                                      int height);
  ~PlatformWindow();
  PlatformWindow(const PlatformWindow&) = delete;
  PlatformWindow& operator=(const PlatformWindow&) = delete;

  /// Takes what the user did; waits for it at most so long (0: not at all). Nothing here keeps the
  /// processor busy.
  void TakeEvents(double timeout_s);
  /// Ends the wait of TakeEvents; from any thread.
  static void Wake();
  /// Whether anything happened since the last call.
  bool TakeActivity();
  bool ShouldClose() const;
  /// Nobody has asked to close it.
  void StayOpen();
  /// What the next window frame gets of what the user did.
  /// @param typing  Text is being typed.
  const WindowInput& NextInput(bool typing);
  /// How long nobody looked for events before the last were taken: their times are as uncertain.
  double blind_s() const { return blind_s_; }
  /// Whether NextInput has more to tell.
  bool HasInput() const { return !input_.empty(); }
  /// What the desktop tells as files are dropped onto the window; scripts do, too.
  void Drop(std::vector<std::string> files);
  /// Files that were dropped onto the window since the last call.
  std::vector<std::string> TakeDroppedFiles();

  void Swap();
  void Resize(int width, int height);
  /// Fills the monitor that the window is on, or goes back to where it was.
  void SetFullScreen(bool on);
  void SetTitle(const std::string& title);
  /// Of the framebuffer [px].
  int width() const;
  int height() const;
  /// What the desktop wants text to be scaled by.
  double content_scale() const;
  /// GL_RENDERER, without what it says in brackets.
  std::string renderer() const;
  bool software_gl() const;
  /// What was drawn, before Swap.
  cv::Mat ReadPixels() const;
  GLFWwindow* handle() const { return window_; }

 private:
  explicit PlatformWindow(GLFWwindow* window);
  void InstallCallbacks();

  GLFWwindow* window_;
  cv::Rect windowed_;  ///< Where it was before it filled the screen; empty: it does not.
  bool activity_ = true;
  InputQueue input_;
  double looked_s_ = 0, blind_s_ = 0;
  std::vector<std::string> dropped_;
};

}  // namespace plumbline
