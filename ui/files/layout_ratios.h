// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <set>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace plumbline {

/// Where one region ends and the next begins, as shares of the room; the user drags them.
struct LayoutRatios {
  double timeline = 0.245;  ///< Height of the timeline, of the whole window.
  double columns = 0.46;    ///< Width of the image views.
  double image = 0.49;      ///< Height of the large image above the four small ones.
  double small_columns = 0.5;
  double small_rows = 0.5;
  double scene = 0.50;    ///< Height of the 3-D view.
  double objects = 0.47;  ///< Height of the object list in what is below the 3-D view.
  double details = 0.60;  ///< Width of the selected object beside the timings.
};
template <class V>
void VisitFields(LayoutRatios& ratios, V&& visit) {
  visit(ratios.timeline, "timeline");
  visit(ratios.columns, "columns");
  visit(ratios.image, "image");
  visit(ratios.small_columns, "small_columns");
  visit(ratios.small_rows, "small_rows");
  visit(ratios.scene, "scene");
  visit(ratios.objects, "objects");
  visit(ratios.details, "details");
}
nlohmann::json RatiosToJson(const LayoutRatios& ratios);
/// Takes what makes sense, keeps the rest.
void RatiosFromJson(const nlohmann::json& json, LayoutRatios& ratios);

inline constexpr std::array<std::string_view, 3> kBuiltInLayouts = {"Overview", "Images", "Map"};

/// Which panels of Inspect there are, and how much room each has.
struct Arrangement {
  LayoutRatios ratios;
  int image_views = 5;
  std::set<std::string> hidden;  ///< Panels, by id.
};
nlohmann::json ToJson(const Arrangement& arrangement);
/// Takes what makes sense; the rest is as in the overview.
Arrangement ArrangementFromJson(const nlohmann::json& json);
/// By name; without those that have none or that of a built-in one.
std::map<std::string, Arrangement> ArrangementsFromJson(const nlohmann::json& json);

}  // namespace plumbline
