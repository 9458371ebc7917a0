// SPDX-License-Identifier: Apache-2.0
#include "ui/files/window_settings.h"

#include <system_error>
#include <type_traits>
#include <utility>

#include "engine/base/files.h"
#include "engine/base/log.h"
#include "ui/files/kept_value.h"

namespace plumbline {

nlohmann::json ReadSettings(const std::filesystem::path& file) {
  std::error_code ignored;
  if (file.empty() || !std::filesystem::exists(file, ignored)) return nlohmann::json::object();
  auto read = ReadJson(file);
  if (read.ok() && read->is_object()) return std::move(read).value();
  log::warn("the window's settings are ignored: {}{}",
            read.ok() ? file.string() + " is no JSON object" : read.error().message,
            SetAside(file));
  return nlohmann::json::object();
}

WindowSettings WindowSettingsFromJson(const nlohmann::json& settings) {
  WindowSettings window;
  const auto take = [&](const char* key, auto& into) {
    const auto found = settings.find(key);
    typename std::decay_t<decltype(into)>::value_type value = {};
    if (found != settings.end() && TakeValue(*found, value)) into = value;
  };
  take("light", window.light);
  take("ui_scale", window.ui_scale);
  window.recent = KeptValue(settings, "recent", window.recent);
  window.places = KeptValue(settings, "places", window.places);
  const auto size = settings.find("window");
  int width = 0, height = 0;
  if (size != settings.end() && size->is_array() && size->size() == 2 &&
      TakeValue(size->at(0), width) && TakeValue(size->at(1), height) && width > 0 && height > 0 &&
      width <= kLargestWindow && height <= kLargestWindow)
    window.size = {width, height};
  return window;
}

std::string SetAside(const std::filesystem::path& file) {
  const std::filesystem::path copy = file.string() + ".damaged";
  std::error_code error;
  std::filesystem::copy_file(file, copy, std::filesystem::copy_options::overwrite_existing, error);
  return error ? std::string() : "; it is kept as " + copy.string();
}

}  // namespace plumbline
