// SPDX-License-Identifier: Apache-2.0
#include "app/platform/window.h"

#include <epoxy/gl.h>
// epoxy comes before GLFW
#include <GLFW/glfw3.h>

#include <array>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "engine/base/log.h"

namespace plumbline {
namespace {

std::string last_glfw_error;  // NOLINT: GLFW reports errors to a plain function

PlatformWindow& Self(GLFWwindow* window) {
  return *static_cast<PlatformWindow*>(glfwGetWindowUserPointer(window));
}

}  // namespace

Result<std::unique_ptr<PlatformWindow>> PlatformWindow::Open(const std::string& title, int width,
                                                             int height) {
  glfwSetErrorCallback([](int, const char* description) { last_glfw_error = description; });
  if (glfwInit() == GLFW_FALSE) {
    return Error{ErrorCode::kUnsupported,
                 "cannot open a window: " + last_glfw_error +
                     "; without a display, 'plumbline demo' writes pictures and a video, and "
                     "'plumbline run' needs no window"};
  }
  constexpr std::array<std::pair<int, int>, 3> kVersions = {{{4, 5}, {4, 3}, {3, 3}}};
  for (const auto& [major, minor] : kVersions) {
    glfwDefaultWindowHints();
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, major);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, minor);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    if (GLFWwindow* window = glfwCreateWindow(width, height, title.c_str(), nullptr, nullptr)) {
      return std::unique_ptr<PlatformWindow>(new PlatformWindow(window));
    }
  }
  glfwTerminate();
  return Error{ErrorCode::kUnsupported, "cannot make an OpenGL 3.3 context: " + last_glfw_error};
}

PlatformWindow::PlatformWindow(GLFWwindow* window) : window_(window) {
  glfwMakeContextCurrent(window_);
  glfwSwapInterval(1);
  glfwSetWindowSizeLimits(window_, 640, 480, GLFW_DONT_CARE, GLFW_DONT_CARE);
  glfwSetWindowUserPointer(window_, this);
  InstallCallbacks();
}

PlatformWindow::~PlatformWindow() {
  glfwDestroyWindow(window_);
  glfwTerminate();
}

void PlatformWindow::InstallCallbacks() {
  glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
    Self(w).activity_ = true;
    Self(w).input_.AddMove(cv::Point2d(x, y), glfwGetTime());
  });
  glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int) {
    Self(w).activity_ = true;
    Self(w).input_.AddButton(button, action == GLFW_PRESS, glfwGetTime());
  });
  glfwSetScrollCallback(window_, [](GLFWwindow* w, double x, double y) {
    Self(w).activity_ = true;
    Self(w).input_.AddWheel({x, y}, glfwGetTime());
  });
  glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int) {
    Self(w).activity_ = true;
    if (action != GLFW_REPEAT) Self(w).input_.AddKey(key, action == GLFW_PRESS, glfwGetTime());
  });
  glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned int character) {
    Self(w).activity_ = true;
    Self(w).input_.AddCharacter(character, glfwGetTime());
  });
  glfwSetCursorEnterCallback(window_, [](GLFWwindow* w, int entered) {
    Self(w).activity_ = true;
    if (entered == GLFW_FALSE) Self(w).input_.AddMove(std::nullopt, glfwGetTime());
  });
  glfwSetWindowFocusCallback(window_, [](GLFWwindow* w, int focused) {
    Self(w).activity_ = true;
    if (focused == GLFW_FALSE) Self(w).input_.LetGo(glfwGetTime());
  });
  glfwSetFramebufferSizeCallback(window_,
                                 [](GLFWwindow* w, int, int) { Self(w).activity_ = true; });
  glfwSetWindowRefreshCallback(window_, [](GLFWwindow* w) { Self(w).activity_ = true; });
  glfwSetWindowCloseCallback(window_, [](GLFWwindow* w) { Self(w).activity_ = true; });
  glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
    Self(w).Drop({paths, paths + count});
  });
}

void PlatformWindow::TakeEvents(double timeout_s) {
  blind_s_ = glfwGetTime() - looked_s_;
  if (timeout_s > 0) {
    glfwWaitEventsTimeout(timeout_s);
  } else {
    glfwPollEvents();
  }
  looked_s_ = glfwGetTime();
}

const WindowInput& PlatformWindow::NextInput(bool typing) {
  return input_.Next(typing, glfwGetTime());
}

void PlatformWindow::Wake() { glfwPostEmptyEvent(); }
bool PlatformWindow::TakeActivity() { return std::exchange(activity_, false); }
bool PlatformWindow::ShouldClose() const { return glfwWindowShouldClose(window_) != 0; }
void PlatformWindow::StayOpen() { glfwSetWindowShouldClose(window_, GLFW_FALSE); }
void PlatformWindow::Drop(std::vector<std::string> files) {
  activity_ = true;
  dropped_ = std::move(files);
}

std::vector<std::string> PlatformWindow::TakeDroppedFiles() { return std::exchange(dropped_, {}); }
void PlatformWindow::Swap() { glfwSwapBuffers(window_); }
void PlatformWindow::Resize(int width, int height) { glfwSetWindowSize(window_, width, height); }

void PlatformWindow::SetFullScreen(bool on) {
  if (on == !windowed_.empty()) return;
  if (!on) {
    glfwSetWindowMonitor(window_, nullptr, windowed_.x, windowed_.y, windowed_.width,
                         windowed_.height, GLFW_DONT_CARE);
    windowed_ = {};
    return;
  }
  GLFWmonitor* monitor = glfwGetPrimaryMonitor();
  const GLFWvidmode* mode = monitor != nullptr ? glfwGetVideoMode(monitor) : nullptr;
  if (mode == nullptr) return;
  glfwGetWindowPos(window_, &windowed_.x, &windowed_.y);
  glfwGetWindowSize(window_, &windowed_.width, &windowed_.height);
  glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

void PlatformWindow::SetTitle(const std::string& title) {
  glfwSetWindowTitle(window_, title.c_str());
}

int PlatformWindow::width() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  return width;
}

int PlatformWindow::height() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(window_, &width, &height);
  return height;
}

double PlatformWindow::content_scale() const {
  float x = 1, y = 1;
  glfwGetWindowContentScale(window_, &x, &y);
  return x;
}

std::string PlatformWindow::renderer() const {
  const std::string text = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return text.substr(0, text.find(" ("));
}

bool PlatformWindow::software_gl() const {
  const std::string name = renderer();
  return name.find("llvmpipe") != std::string::npos || name.find("softpipe") != std::string::npos;
}

cv::Mat PlatformWindow::ReadPixels() const {
  cv::Mat pixels(height(), width(), CV_8UC3);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
  glReadBuffer(GL_BACK);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, pixels.cols, pixels.rows, GL_BGR, GL_UNSIGNED_BYTE, pixels.data);
  cv::Mat upright;
  cv::flip(pixels, upright, 0);
  return upright;
}

}  // namespace plumbline
