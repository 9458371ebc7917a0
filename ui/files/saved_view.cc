// SPDX-License-Identifier: Apache-2.0
#include "ui/files/saved_view.h"

#include <algorithm>
#include <numbers>

#include "engine/geometry/reach.h"
#include "ui/files/kept_value.h"

namespace plumbline {
namespace {

constexpr ScanColoring kColorings[] = {ScanColoring::kOwn, ScanColoring::kHeight,
                                       ScanColoring::kNormal};

bool IsPlace(const nlohmann::json& list, Eigen::Vector3d& place) {
  if (!list.is_array() || list.size() != 3) return false;
  for (int i = 0; i < 3; ++i) {
    if (!TakeValue(list[static_cast<std::size_t>(i)], place[i])) return false;
  }
  return place.cwiseAbs().maxCoeff() <= kFarthest_m;
}

}  // namespace

const char* KeyOf(ScanColoring coloring) {
  return coloring == ScanColoring::kOwn      ? "own"
         : coloring == ScanColoring::kHeight ? "height"
                                             : "normal";
}

nlohmann::json ToJson(const ScanLook& look) {
  nlohmann::json json = {{"point_px", look.point_px}};
  if (look.coloring) json["coloring"] = KeyOf(*look.coloring);
  return json;
}

ScanLook ScanLookFromJson(const nlohmann::json& json) {
  ScanLook look;
  look.point_px = std::clamp(KeptValue(json, "point_px", look.point_px), kFewestPx, kMostPx);
  const std::string key = KeptValue(json, "coloring", std::string());
  for (const ScanColoring coloring : kColorings) {
    if (key == KeyOf(coloring)) look.coloring = coloring;
  }
  return look;
}

nlohmann::json ToJson(const std::vector<SavedView>& views) {
  nlohmann::json json = nlohmann::json::array();
  for (const SavedView& view : views) {
    const SceneCamera& camera = view.camera;
    json.push_back(
        {{"name", view.name},
         {"focus",
          {camera.focus_in_world.x(), camera.focus_in_world.y(), camera.focus_in_world.z()}},
         {"azimuth_rad", camera.azimuth_rad},
         {"elevation_rad", camera.elevation_rad},
         {"distance_m", camera.distance_m}});
  }
  return json;
}

std::vector<SavedView> SavedViewsFromJson(const nlohmann::json& json) {
  constexpr double kTurn = 2 * std::numbers::pi;
  std::vector<SavedView> views;
  if (!json.is_array()) return views;
  for (const nlohmann::json& entry : json) {
    SavedView view{KeptValue(entry, "name", std::string()), {}};
    const auto focus = entry.find("focus");
    if (views.size() >= kMostViews || view.name.empty() || focus == entry.end() ||
        !IsPlace(*focus, view.camera.focus_in_world))
      continue;
    view.camera.azimuth_rad = std::clamp(KeptValue(entry, "azimuth_rad", 0.0), -kTurn, kTurn);
    view.camera.elevation_rad = std::clamp(KeptValue(entry, "elevation_rad", 0.5), -kTurn, kTurn);
    view.camera.distance_m = std::clamp(KeptValue(entry, "distance_m", 3.0), 0.05, 500.0);
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace plumbline
