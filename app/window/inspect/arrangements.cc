// SPDX-License-Identifier: Apache-2.0
#include "app/window/inspect/arrangements.h"

#include <algorithm>

namespace plumbline {
namespace {

/// In the order of kBuiltInLayouts.
Arrangement BuiltIn(std::size_t index) {
  Arrangement made;
  if (index == 1) {  // a large image, with two beside one another below
    made.ratios.columns = 0.68;
    made.ratios.image = 0.72;
    made.ratios.timeline = 0.16;
    made.ratios.scene = 0.44;
    made.ratios.objects = 0.42;
    made.image_views = 3;
    made.hidden = {"timings"};
  } else if (index == 2) {
    made.ratios.columns = 0.28;
    made.ratios.image = 0.5;
    made.ratios.timeline = 0.16;
    made.ratios.scene = 0.74;
    made.image_views = 2;
    made.hidden = {"timings", "details", "why", "posterior", "particle_table"};
  }
  return made;
}

}  // namespace

std::optional<Arrangement> Arrangements::Find(const std::string& name) const {
  const auto built_in = std::find(kBuiltInLayouts.begin(), kBuiltInLayouts.end(), name);
  if (built_in != kBuiltInLayouts.end())
    return BuiltIn(static_cast<std::size_t>(built_in - kBuiltInLayouts.begin()));
  const auto own = own_.find(name);
  return own != own_.end() ? std::optional(own->second) : std::nullopt;
}

bool Arrangements::Keep(const std::string& name, const Arrangement& arrangement) {
  const bool taken =
      std::find(kBuiltInLayouts.begin(), kBuiltInLayouts.end(), name) != kBuiltInLayouts.end();
  if (name.empty() || taken) return false;
  own_[name] = arrangement;
  return true;
}

std::vector<std::string> Arrangements::own_names() const {
  std::vector<std::string> names;
  for (const auto& [name, arrangement] : own_) names.push_back(name);
  return names;
}

nlohmann::json Arrangements::Save() const {
  nlohmann::json json = nlohmann::json::object();
  for (const auto& [name, arrangement] : own_) json[name] = ToJson(arrangement);
  return json;
}

}  // namespace plumbline
