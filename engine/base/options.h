// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// How one field of an options struct is shown and checked. Written once, beside the struct, in
/// `template <class V> void VisitFields(MyOptions& o, V&& visit)`, which calls `visit(field,
/// info)`; JSON, the command line and the window's editor all read it.
struct FieldInfo {
  std::string_view name;
  std::string_view unit;  ///< "" where the number has none.
  std::string_view help;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

/// Enumerations name their values by specialising this: `static constexpr std::string_view
/// names[]`, in the order of the enumerators, which count from 0.
template <typename E>
struct EnumNames;

/// The name among `candidates` with the smallest edit distance to `word` ("" if there are none).
std::string NearestName(std::string_view word, const std::vector<std::string>& candidates);

namespace internal {
std::string OutOfRange(const FieldInfo& info, double value);

template <typename T>
Status FieldFromJson(T& field, const FieldInfo& info, const nlohmann::json& json) {
  const auto wrong = [&](std::string_view wanted) {
    return Error{ErrorCode::kInvalidInput, "option '" + std::string(info.name) + "' must be " +
                                               std::string(wanted) + ", not " + json.dump()};
  };
  if constexpr (std::is_same_v<T, bool>) {
    if (!json.is_boolean()) return wrong("true or false");
    field = json.get<bool>();
  } else if constexpr (std::is_enum_v<T>) {
    if (json.is_string()) {
      std::vector<std::string> names;
      for (std::size_t i = 0; i < std::size(EnumNames<T>::names); ++i) {
        if (json.get<std::string>() == EnumNames<T>::names[i]) {
          field = static_cast<T>(i);
          return {};
        }
        names.emplace_back(EnumNames<T>::names[i]);
      }
      std::string all;
      for (const auto& name : names) all += (all.empty() ? "" : ", ") + name;
      return wrong("one of " + all);
    }
    return wrong("a name");
  } else if constexpr (std::is_arithmetic_v<T>) {
    if (!json.is_number()) return wrong("a number");
    const double value = json.get<double>();
    if (!(value >= info.min && value <= info.max))
      return Error{ErrorCode::kInvalidInput, OutOfRange(info, value)};
    if (std::is_integral_v<T> && !json.is_number_integer()) return wrong("a whole number");
    field = json.get<T>();
  } else {
    if (!json.is_string()) return wrong("a text");
    field = json.get<T>();
  }
  return {};
}
}  // namespace internal

/// Names that fields had in earlier versions: {old, new}. They stay good in files and on the
/// command line. Specialised beside the options.
template <typename Options>
struct FormerNames {
  static constexpr std::array<std::pair<std::string_view, std::string_view>, 0> names = {};
};

/// Every field with its present value.
template <typename Options>
nlohmann::json OptionsToJson(const Options& options) {
  nlohmann::json json = nlohmann::json::object();
  VisitFields(const_cast<Options&>(options), [&](auto& field, const FieldInfo& info) {
    using T = std::remove_reference_t<decltype(field)>;
    if constexpr (std::is_enum_v<T>) {
      json[std::string(info.name)] = EnumNames<T>::names[static_cast<std::size_t>(field)];
    } else {
      json[std::string(info.name)] = field;
    }
  });
  return json;
}

/// Overwrites the fields that `given` names; the others keep their values. Errors (kInvalidInput):
/// an unknown key (with the nearest known name), a wrong type, a value out of range. On error
/// `options` is unchanged.
template <typename Options>
Status OptionsFromJson(const nlohmann::json& given, Options& options) {
  if (!given.is_object()) return Error{ErrorCode::kInvalidInput, "options must be a JSON object"};
  nlohmann::json json = given;
  for (const auto& [former, name] : FormerNames<Options>::names) {
    const auto found = json.find(std::string(former));
    if (found == json.end()) continue;
    const nlohmann::json value = *found;
    json.erase(found);
    json.emplace(std::string(name), value);  // where both are given, the present name counts
  }
  Options result = options;
  std::vector<std::string> known;
  VisitFields(result, [&](auto&, const FieldInfo& info) { known.emplace_back(info.name); });
  for (const auto& [key, value] : json.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      return Error{ErrorCode::kInvalidInput,
                   "unknown option '" + key + "'; did you mean '" + NearestName(key, known) + "'?"};
    }
  }
  Status status;
  VisitFields(result, [&](auto& field, const FieldInfo& info) {
    const auto found = json.find(std::string(info.name));
    if (status.ok() && found != json.end()) status = internal::FieldFromJson(field, info, *found);
  });
  if (status.ok()) options = result;
  return status;
}

/// Applies one `key=value` as given by `--set`; the value is read as JSON, else as text.
template <typename Options>
Status SetOption(std::string_view assignment, Options& options) {
  const std::size_t equals = assignment.find('=');
  if (equals == std::string_view::npos) {
    return Error{ErrorCode::kInvalidInput,
                 "'" + std::string(assignment) + "' is not of the form key=value"};
  }
  const std::string text(assignment.substr(equals + 1));
  nlohmann::json value = nlohmann::json::parse(text, nullptr, false);
  if (value.is_discarded()) value = text;
  return OptionsFromJson(nlohmann::json{{std::string(assignment.substr(0, equals)), value}},
                         options);
}

}  // namespace plumbline
