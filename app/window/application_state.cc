// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <utility>

#include "app/window/application.h"
#include "engine/base/files.h"
#include "engine/base/log.h"
#include "ui/files/window_settings.h"

// What the window tells of itself to scripts and tests, and what it keeps from one day to the next.

namespace plumbline {

std::filesystem::path DefaultSettingsFile() {
  if (const char* config = std::getenv("XDG_CONFIG_HOME"); config != nullptr && *config != '\0') {
    return std::filesystem::path(config) / "plumbline" / "window.json";
  }
  const char* home = std::getenv("HOME");
  if (home == nullptr || *home == '\0') return {};
  return std::filesystem::path(home) / ".config" / "plumbline" / "window.json";
}

void Application::WriteStateFile() {
  nlohmann::json state = State();
  state.erase("panels");
  std::string text = state.dump();
  if (text == written_state_) return;
  const Status status = WriteFileAtomically(options_.state_file, text);
  if (!status.ok()) log::warn("{}", status.error().message);
  written_state_ = std::move(text);
}

nlohmann::json Application::State() const {
  nlohmann::json state = {
      {"workspace", context_.workspace == WorkspaceId::kAnnotate ? "annotate" : "inspect"},
      {"light", context_.light},
      {"palette", palette_.open},
      {"help", context_.help_shown},
      {"path_dialog", path_dialog_.is_open()},
      {"recent", context_.recent},
      {"ui_scale", context_.ui_scale},
      {"window", {window_->width(), window_->height()}}};
  for (const Workspace* workspace : workspaces()) workspace->AddState(context_, state);
  for (const auto& [name, rect] : widgets_.rects()) {
    state["widgets"][name] = {rect.low.x, rect.low.y, rect.high.x, rect.high.y};
  }
  return state;
}

void Application::LoadSettings() {
  const nlohmann::json settings = ReadSettings(options_.settings);
  for (Workspace* workspace : workspaces()) workspace->LoadSettings(settings, context_);
  WindowSettings window = WindowSettingsFromJson(settings);
  if (window.light) context_.light = *window.light;
  context_.recent = std::move(window.recent);
  path_dialog_.SetPlaces(std::move(window.places));
  if (window.ui_scale) wanted_scale_ = window.ui_scale;
  if (window.size) window_->Resize(window.size->first, window.size->second);
}

void Application::SaveSettings() const {
  if (options_.settings.empty()) return;
  nlohmann::json settings = {{"ui_scale", context_.ui_scale},
                             {"light", context_.light},
                             {"recent", context_.recent},
                             {"places", path_dialog_.places()},
                             {"window", {window_->width(), window_->height()}}};
  for (const Workspace* workspace : workspaces()) workspace->SaveSettings(context_, settings);
  std::error_code ignored;
  std::filesystem::create_directories(options_.settings.parent_path(), ignored);
  const Status status = WriteJson(options_.settings, settings);
  if (!status.ok()) log::warn("the window's settings are not kept: {}", status.error().message);
}

}  // namespace plumbline
