// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace plumbline {

// Each takes a value of its type that fits and says so; of lists, the texts among the elements.
bool TakeValue(const nlohmann::json& value, bool& into);
bool TakeValue(const nlohmann::json& value, int& into);
bool TakeValue(const nlohmann::json& value, std::size_t& into);
bool TakeValue(const nlohmann::json& value, float& into);
bool TakeValue(const nlohmann::json& value, double& into);
bool TakeValue(const nlohmann::json& value, std::string& into);
bool TakeValue(const nlohmann::json& value, std::vector<std::string>& into);
bool TakeValue(const nlohmann::json& value, std::set<std::string>& into);

/// What settings hold under a key; `fallback` where they hold nothing or something else: one wrong
/// value costs no other. `json` may be anything.
template <typename T>
T KeptValue(const nlohmann::json& json, const char* key, T fallback) {
  const auto found = json.find(key);
  if (found != json.end()) TakeValue(*found, fallback);
  return fallback;
}

/// The object under a key; an empty one where there is none.
nlohmann::json KeptObject(const nlohmann::json& json, const char* key);

}  // namespace plumbline
