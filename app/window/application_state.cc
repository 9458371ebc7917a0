// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "app/window/application.h"
#include "app/window/inspect/bookmarks.h"
#include "engine/base/files.h"
#include "engine/base/log.h"

// What the window tells of itself to scripts and tests, and what it keeps from one day to the next.

namespace plumbline {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

const char* StateName(PlaybackState state) {
  switch (state) {
    case PlaybackState::kPaused:
      return "paused";
    case PlaybackState::kPlaying:
      return "playing";
    case PlaybackState::kFinished:
      return "finished";
    case PlaybackState::kFailed:
      return "failed";
  }
  return "";
}

}  // namespace

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
  const PlaybackView& playback = *context_.playback;
  const SceneCamera camera = scene_->camera();
  nlohmann::json state = {
      {"frame", context_.snapshot != nullptr ? context_.snapshot->report.frame : -1},
      {"playback_frame", playback.frame},
      {"newest_frame", playback.newest_mapped_frame},
      {"open", context_.sequence != nullptr},
      {"num_frames", context_.sequence != nullptr ? context_.sequence->num_frames : 0},
      {"state", StateName(playback.state)},
      {"seeking", playback.seek_target.has_value()},
      {"recorded", playback.recorded},
      {"speed", playback.speed},
      {"mapping", playback.mapping},
      {"follow_newest", playback.follow},
      {"loop", playback.loop},
      {"range", {playback.range_begin.value_or(-1), playback.range_end.value_or(-1)}},
      {"history", std::count_if(playback.history->frames.begin(), playback.history->frames.end(),
                                [](const auto& sample) { return sample != nullptr; })},
      {"message", playback.message},
      {"objects", context_.snapshot != nullptr ? context_.snapshot->report.objects.size() : 0},
      {"selected_object", context_.selection.object.value},
      {"selected_particle", context_.selection.particle},
      {"hovered_particle", context_.selection.hovered},
      {"outlined_particle", context_.probe != nullptr ? context_.probe->hovered : -1},
      {"selected_hypothesis", context_.selection.hypothesis},
      {"probe_frame", context_.probe != nullptr ? context_.probe->frame : -1},
      {"verdict", context_.probe != nullptr ? context_.probe->verdict : ""},
      {"details_tab", details_tab_},
      {"follow", context_.follow},
      {"look_through", context_.look_through},
      {"light", context_.light},
      {"palette", palette_.open},
      {"help", show_help_},
      {"presenting", presenter_.active()},
      {"shot", presenter_.shot()},
      {"ui_scale", context_.ui_scale},
      {"window", {window_->width(), window_->height()}},
      {"image_zoom", viewport_.zoom},
      {"scene_renders", scene_->renders()},
      {"camera",
       {{"azimuth_deg", camera.azimuth_rad * kDegrees},
        {"elevation_deg", camera.elevation_rad * kDegrees},
        {"distance_m", camera.distance_m},
        {"focus",
         {camera.focus_in_world.x(), camera.focus_in_world.y(), camera.focus_in_world.z()}}}},
      {"layout", RatiosToJson(ratios_)}};
  state["source"] = context_.source;
  state["models"] = models_;
  state["workspace"] = context_.workspace == WorkspaceId::kAnnotate ? "annotate" : "inspect";
  annotate_->AddState(context_, state);
  state["image_views"] = views_->Save(context_);
  AddWhatIfState(context_, fork_sheet_, state);
  for (const Bookmark& bookmark : context_.bookmarks)
    state["bookmarks"].push_back({{"frame", bookmark.frame}, {"note", bookmark.note}});
  for (const Panel* panel : panels_) state["panels"][panel->Id()] = panel->SaveState();
  for (const auto& [name, rect] : widgets_.rects()) {
    state["widgets"][name] = {rect.low.x, rect.low.y, rect.high.x, rect.high.y};
  }
  return state;
}

void Application::LoadSettings() {
  if (options_.settings.empty() || !std::filesystem::exists(options_.settings)) return;
  const auto settings = ReadJson(options_.settings);
  if (!settings.ok())
    return log::warn("the window's settings are ignored: {}", settings.error().message);
  try {
    RatiosFromJson(settings->value("layout", nlohmann::json::object()), ratios_);
    const auto panels = settings->value("panels", nlohmann::json::object());
    for (Panel* panel : panels_) {
      if (panels.contains(panel->Id())) panel->LoadState(panels.at(panel->Id()));
    }
    views_->Load(settings->value("image_views", nlohmann::json::object()), context_);
    annotate_->LoadSettings(settings->value("annotate", nlohmann::json::object()));
    context_.light = settings->value("light", false);
    details_tab_ = settings->value("details_tab", details_tab_);
    context_.recent = settings->value("recent", std::vector<std::string>());
    if (settings->contains("ui_scale")) wanted_scale_ = settings->at("ui_scale").get<double>();
    if (settings->contains("window")) {
      window_->Resize(settings->at("window").at(0), settings->at("window").at(1));
    }
  } catch (const nlohmann::json::exception& error) {
    log::warn("{}: some settings are ignored: {}", options_.settings.string(), error.what());
  }
}

void Application::SaveSettings() const {
  if (options_.settings.empty()) return;
  nlohmann::json settings = {
      {"layout", RatiosToJson(ratios_)}, {"ui_scale", context_.ui_scale},
      {"details_tab", details_tab_},     {"light", context_.light},
      {"recent", context_.recent},       {"window", {window_->width(), window_->height()}}};
  settings["image_views"] = views_->Save(context_);
  settings["annotate"] = annotate_->SaveSettings();
  for (const Panel* panel : panels_) settings["panels"][panel->Id()] = panel->SaveState();
  std::error_code ignored;
  std::filesystem::create_directories(options_.settings.parent_path(), ignored);
  const Status status = WriteJson(options_.settings, settings);
  if (!status.ok()) log::warn("the window's settings are not kept: {}", status.error().message);
}

}  // namespace plumbline
