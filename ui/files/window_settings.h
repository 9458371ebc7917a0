// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// What is kept of the window as a whole; the workspaces keep the rest in the same file.
struct WindowSettings {
  std::optional<bool> light;        ///< Theme.
  std::vector<std::string> recent;  ///< What was open, the last one first.
  std::vector<std::string> places;  ///< Folders that were used.
  std::optional<double> ui_scale;
  std::optional<std::pair<int, int>> size;  ///< Of the window, in its own units.
};

/// The largest side of a window: more than any screen has.
inline constexpr int kLargestWindow = 16384;

/// Settings that the file has; an empty object where there is no file or it cannot be read, which
/// the log tells: a copy stays beside it (SetAside).
nlohmann::json ReadSettings(const std::filesystem::path& file);
/// What makes sense; the rest is as by default.
WindowSettings WindowSettingsFromJson(const nlohmann::json& settings);

/// Copies a damaged file to FILE.damaged, since the window will write a new one, and says so as the
/// end of a sentence; "" where it cannot.
std::string SetAside(const std::filesystem::path& file);

}  // namespace plumbline
