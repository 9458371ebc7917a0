// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotated_instance.h"

#include <utility>

#include <nlohmann/json.hpp>

#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

using Written = InstanceField::Written;

constexpr std::string_view kQuality = "quality";

nlohmann::json ValueToJson(std::string_view, const std::string& text) { return text; }
nlohmann::json ValueToJson(std::string_view, double number) { return number; }
nlohmann::json ValueToJson(std::string_view, const Eigen::Isometry3d& pose) {
  return IsometryToJson(pose);
}
nlohmann::json ValueToJson(std::string_view key, bool on) {
  if (key == kQuality) return on ? "fine" : "coarse";
  return on;
}

// True if the JSON is a value of this field.
bool ValueFromJson(std::string_view, const nlohmann::json& source, std::string& text) {
  if (source.is_string()) text = source.get<std::string>();
  return source.is_string();
}
bool ValueFromJson(std::string_view, const nlohmann::json& source, double& number) {
  if (source.is_number()) number = source.get<double>();
  return source.is_number();
}
bool ValueFromJson(std::string_view, const nlohmann::json& source, Eigen::Isometry3d& pose) {
  const auto read = IsometryFromJson(source);
  if (read) pose = *read;
  return read.has_value();
}
bool ValueFromJson(std::string_view key, const nlohmann::json& source, bool& on) {
  if (key == kQuality) {
    on = source == "fine";
    return source == "fine" || source == "coarse";
  }
  if (source.is_boolean()) on = source.get<bool>();
  return source.is_boolean();
}

std::string Wanted(std::string_view key, const std::string&) {
  return "needs a text '" + std::string(key) + "'";
}
std::string Wanted(std::string_view key, double) {
  return "needs a number '" + std::string(key) + "'";
}
std::string Wanted(std::string_view key, const Eigen::Isometry3d&) {
  return "needs a '" + std::string(key) +
         "' that is a 4x4 rigid transform, row by row, within 1000 km";
}
std::string Wanted(std::string_view key, bool) {
  return key == kQuality ? "has a 'quality' that is neither fine nor coarse"
                         : "has a '" + std::string(key) + "' that is neither true nor false";
}

template <typename T>
bool IsEmpty(const T& value) {
  if constexpr (std::is_same_v<T, std::string>) return value.empty();
  return false;
}

bool IsSame(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  return a.matrix() == b.matrix();
}
template <typename T>
bool IsSame(const T& a, const T& b) {
  return a == b;
}

std::string KeyInChange(std::string_view key) { return key == "id" ? "new_id" : std::string(key); }

}  // namespace

InstanceChange ChangeFields(const InstanceChange& change, AnnotatedInstance& instance) {
  InstanceChange back;
  const auto exchange = [](const InstanceField&, const auto& wanted, auto& field, auto& old) {
    if (wanted) old = std::exchange(field, *wanted);
  };
  VisitInstance(exchange, change, instance, back);
  return back;
}

nlohmann::json InstanceToJson(const AnnotatedInstance& instance) {
  nlohmann::json result = nlohmann::json::object();
  const auto write = [&](const InstanceField& field, const auto& value, const auto& usual) {
    if (field.written == Written::kUnlessDefault && IsSame(value, usual)) return;
    result[std::string(field.key)] = ValueToJson(field.key, value);
  };
  VisitInstance(write, instance, AnnotatedInstance());
  return result;
}

Result<AnnotatedInstance> InstanceFromJson(const nlohmann::json& source) {
  if (!source.is_object()) return InvalidInput("an instance must be a JSON object");
  AnnotatedInstance instance;
  std::string problem;
  const auto read = [&](const InstanceField& field, auto& value) {
    if (!problem.empty()) return;
    const auto found = source.find(field.key);
    const bool required = field.written == Written::kRequired;
    const bool good = found == source.end() ? !required : ValueFromJson(field.key, *found, value);
    if (good && !(required && IsEmpty(value))) return;
    problem = (field.key == "id" ? "an instance " : "instance '" + instance.id + "' ") +
              Wanted(field.key, value);
  };
  VisitInstance(read, instance);
  if (!problem.empty()) return InvalidInput(problem);
  return instance;
}

nlohmann::json ChangeToJson(const InstanceChange& change) {
  nlohmann::json result = nlohmann::json::object();
  const auto write = [&](const InstanceField& field, const auto& value) {
    if (value) result[KeyInChange(field.key)] = ValueToJson(field.key, *value);
  };
  VisitInstance(write, change);
  return result;
}

Result<InstanceChange> ChangeFromJson(const nlohmann::json& source) {
  InstanceChange change;
  for (const auto& [key, value] : source.items()) {
    if (key == "edit" || key == "id") continue;
    bool known = false, good = false;
    const auto read = [&, &name = key, &from = value](const InstanceField& field, auto& wanted) {
      if (KeyInChange(field.key) != name) return;
      known = true;
      good = ValueFromJson(field.key, from, wanted.emplace());
    };
    VisitInstance(read, change);
    if (!known) return InvalidInput("an edit 'change' knows no '" + key + "'");
    if (!good) {
      return InvalidInput("'" + key + "' of the change of '" +
                          TextFromJson(source, "id").value_or("") + "' has a wrong value");
    }
  }
  return change;
}

}  // namespace plumbline
