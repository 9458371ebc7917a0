// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "ui/files/layout_ratios.h"

namespace plumbline {

/// The built-in arrangements (kBuiltInLayouts) and those that the user has kept.
class Arrangements {
 public:
  /// Nothing if there is none of that name; a built-in one comes first.
  std::optional<Arrangement> Find(const std::string& name) const;
  /// False for an empty name and that of a built-in one.
  bool Keep(const std::string& name, const Arrangement& arrangement);
  void Forget(const std::string& name) { own_.erase(name); }
  std::vector<std::string> own_names() const;
  nlohmann::json Save() const;
  void Load(const nlohmann::json& json) { own_ = ArrangementsFromJson(json); }

 private:
  std::map<std::string, Arrangement> own_;
};

}  // namespace plumbline
