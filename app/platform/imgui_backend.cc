// SPDX-License-Identifier: Apache-2.0
#include "app/platform/imgui_backend.h"

#include <epoxy/gl.h>
// epoxy comes before the backends
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
// and before GLFW
#include <GLFW/glfw3.h>

#include <algorithm>
#include <cfloat>
#include <iterator>

namespace plumbline {

ImGuiBackend::ImGuiBackend(PlatformWindow& window) : window_(window) {
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplGlfw_InitForOpenGL(window_.handle(), false);  // events come by the window
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

ImGuiBackend::~ImGuiBackend() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
  ImGui::DestroyContext();
}

void ImGuiBackend::TakeInput() {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
  // The backend knows only how keys and mouse are now, not what was done since the last frame.
  ImGuiIO& io = ImGui::GetIO();
  const WindowInput& input = window_.NextInput(io.WantTextInput);
  for (std::size_t key = 0; key < input.keys.size(); ++key) io.KeysDown[key] = input.keys[key];
  io.KeyShift = input.keys[GLFW_KEY_LEFT_SHIFT] || input.keys[GLFW_KEY_RIGHT_SHIFT];
  io.KeyCtrl = input.keys[GLFW_KEY_LEFT_CONTROL] || input.keys[GLFW_KEY_RIGHT_CONTROL];
  io.KeyAlt = input.keys[GLFW_KEY_LEFT_ALT] || input.keys[GLFW_KEY_RIGHT_ALT];
  io.KeySuper = input.keys[GLFW_KEY_LEFT_SUPER] || input.keys[GLFW_KEY_RIGHT_SUPER];
  for (const char32_t character : input.characters) io.AddInputCharacter(character);
  for (std::size_t i = 0; i < std::size(io.MouseDown); ++i) io.MouseDown[i] = input.buttons[i];
  io.MousePos = {-FLT_MAX, -FLT_MAX};
  if (const auto& mouse = input.mouse_px)
    io.MousePos = {static_cast<float>(mouse->x), static_cast<float>(mouse->y)};
  io.MouseWheelH = static_cast<float>(input.wheel.x);
  io.MouseWheel = static_cast<float>(input.wheel.y);
  // Two clicks are a double click by when they were done, however long the frames take.
  constexpr double kShortest_s = 1e-5, kDoubleClick_s = 0.3, kMostDoubt_s = 0.7;
  io.MouseDoubleClickTime =
      static_cast<float>(kDoubleClick_s + std::min(window_.blind_s(), kMostDoubt_s));
  // Tab goes from field to field; where nothing is typed, workspaces have their own use for it.
  io.KeyMap[ImGuiKey_Tab] = io.WantTextInput ? GLFW_KEY_TAB : -1;
  io.DeltaTime = static_cast<float>(std::max(kShortest_s, input.time_s - input_time_s_));
  input_time_s_ = input.time_s;
}

void ImGuiBackend::Draw() {
  // VTK and the textures drew with their own state before.
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
  glViewport(0, 0, window_.width(), window_.height());
  glDisable(GL_SCISSOR_TEST);
  glClearColor(0, 0, 0, 1);
  glClear(GL_COLOR_BUFFER_BIT);
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void ImGuiBackend::ReloadFonts() {
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
}

}  // namespace plumbline
