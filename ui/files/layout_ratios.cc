// SPDX-License-Identifier: Apache-2.0
#include "ui/files/layout_ratios.h"

#include <algorithm>

#include "ui/files/kept_value.h"

namespace plumbline {

nlohmann::json RatiosToJson(const LayoutRatios& ratios) {
  nlohmann::json json;
  VisitFields(const_cast<LayoutRatios&>(ratios),
              [&](double& ratio, const char* name) { json[name] = ratio; });
  return json;
}

void RatiosFromJson(const nlohmann::json& json, LayoutRatios& ratios) {
  VisitFields(ratios, [&](double& ratio, const char* name) {
    ratio = std::clamp(KeptValue(json, name, ratio), 0.05, 0.85);
  });
}

nlohmann::json ToJson(const Arrangement& arrangement) {
  return {{"ratios", RatiosToJson(arrangement.ratios)},
          {"image_views", arrangement.image_views},
          {"hidden", arrangement.hidden}};
}

Arrangement ArrangementFromJson(const nlohmann::json& json) {
  Arrangement made;
  RatiosFromJson(KeptObject(json, "ratios"), made.ratios);
  made.image_views = KeptValue(json, "image_views", made.image_views);
  made.hidden = KeptValue(json, "hidden", made.hidden);
  return made;
}

std::map<std::string, Arrangement> ArrangementsFromJson(const nlohmann::json& json) {
  std::map<std::string, Arrangement> own;
  if (!json.is_object()) return own;
  for (const auto& [name, arrangement] : json.items()) {
    const bool taken =
        std::find(kBuiltInLayouts.begin(), kBuiltInLayouts.end(), name) != kBuiltInLayouts.end();
    if (!name.empty() && !taken) own.insert_or_assign(name, ArrangementFromJson(arrangement));
  }
  return own;
}

}  // namespace plumbline
