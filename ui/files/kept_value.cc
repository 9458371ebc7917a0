// SPDX-License-Identifier: Apache-2.0
#include "ui/files/kept_value.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "engine/base/json_text.h"

namespace plumbline {

bool TakeValue(const nlohmann::json& value, bool& into) {
  if (value.is_boolean()) into = value.get<bool>();
  return value.is_boolean();
}

bool TakeValue(const nlohmann::json& value, int& into) {
  try {
    into = IntFromJson(value);
    return true;
  } catch (const std::range_error&) {
    return false;
  }
}

bool TakeValue(const nlohmann::json& value, std::size_t& into) {
  try {
    into = UnsignedFromJson(value);
    return true;
  } catch (const std::range_error&) {
    return false;
  }
}

bool TakeValue(const nlohmann::json& value, float& into) {
  const bool fits = value.is_number() &&
                    std::abs(value.get<double>()) <= double{std::numeric_limits<float>::max()};
  if (fits) into = static_cast<float>(value.get<double>());
  return fits;
}

bool TakeValue(const nlohmann::json& value, double& into) {
  if (value.is_number()) into = value.get<double>();
  return value.is_number();
}

bool TakeValue(const nlohmann::json& value, std::string& into) {
  if (value.is_string()) into = value.get<std::string>();
  return value.is_string();
}

bool TakeValue(const nlohmann::json& value, std::vector<std::string>& into) {
  if (!value.is_array()) return false;
  into.clear();
  for (const nlohmann::json& element : value) {
    if (element.is_string()) into.push_back(element.get<std::string>());
  }
  return true;
}

bool TakeValue(const nlohmann::json& value, std::set<std::string>& into) {
  std::vector<std::string> texts;
  if (!TakeValue(value, texts)) return false;
  into = {texts.begin(), texts.end()};
  return true;
}

nlohmann::json KeptObject(const nlohmann::json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_object() ? *found : nlohmann::json::object();
}

}  // namespace plumbline
