// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace plumbline {

/// A turntable camera about `focus`, in numbers.
struct SceneCamera {
  Eigen::Vector3d focus_in_world{0, 0, 0};
  double azimuth_rad = 0, elevation_rad = 0, distance_m = 1;
  Eigen::Matrix3d view_from_world =
      Eigen::Matrix3d::Identity();  ///< x right, y up, z to the viewer
  double view_angle_rad = 0.7;      ///< From the lower edge to the upper.
  /// Without perspective: what is at the focus is as large as with it.
  bool parallel = false;
};

/// A view to come back to.
struct SavedView {
  std::string name;
  SceneCamera camera;
};
inline constexpr std::size_t kMostViews = 20;

/// What the colours of the scan mean: its own, how high it is there, how its surface is turned.
enum class ScanColoring { kOwn, kHeight, kNormal };
/// In settings and widgets.
const char* KeyOf(ScanColoring coloring);

/// How the scan is drawn.
struct ScanLook {
  std::optional<ScanColoring> coloring;  ///< Nothing: its own, or height where it has none.
  float point_px = 1.5f;                 ///< Of a scan without triangles.
  bool operator==(const ScanLook&) const = default;
};
inline constexpr float kFewestPx = 1, kMostPx = 8;

// What the settings keep. What cannot be read is left out.
nlohmann::json ToJson(const ScanLook& look);
ScanLook ScanLookFromJson(const nlohmann::json& json);
nlohmann::json ToJson(const std::vector<SavedView>& views);
std::vector<SavedView> SavedViewsFromJson(const nlohmann::json& json);

}  // namespace plumbline
