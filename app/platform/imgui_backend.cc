// SPDX-License-Identifier: Apache-2.0
#include "app/platform/imgui_backend.h"

#include <epoxy/gl.h>
// epoxy comes before the backends
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
// and before GLFW
#include <GLFW/glfw3.h>

namespace plumbline {

ImGuiBackend::ImGuiBackend(PlatformWindow& window) : window_(window) {
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplGlfw_InitForOpenGL(window_.handle(), true);
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
  // The backend keeps only the last state of a key and would lose short strokes.
  ImGuiIO& io = ImGui::GetIO();
  const auto& keys = window_.NextKeys();
  for (std::size_t key = 0; key < keys.size(); ++key) io.KeysDown[key] = keys[key];
  io.KeyShift = keys[GLFW_KEY_LEFT_SHIFT] || keys[GLFW_KEY_RIGHT_SHIFT];
  io.KeyCtrl = keys[GLFW_KEY_LEFT_CONTROL] || keys[GLFW_KEY_RIGHT_CONTROL];
  io.KeyAlt = keys[GLFW_KEY_LEFT_ALT] || keys[GLFW_KEY_RIGHT_ALT];
  io.KeySuper = keys[GLFW_KEY_LEFT_SUPER] || keys[GLFW_KEY_RIGHT_SUPER];
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
