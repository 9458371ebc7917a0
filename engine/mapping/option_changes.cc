// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/option_changes.h"

#include "engine/base/files.h"
#include "engine/base/json_text.h"

namespace plumbline {
namespace {

constexpr std::string_view kBecomes = " -> ", kNext = "; ";

Error NotAChange(std::string_view part) {
  return {ErrorCode::kCorrupt, "'" + std::string(part) + "' is not a change of an option"};
}

/// Objects of pairs; discarded otherwise.
nlohmann::json ParseChanges(std::string_view changes) {
  nlohmann::json json = ParseJson(changes);
  bool pairs = json.is_object();
  for (const auto& [name, values] : json.items())
    pairs = pairs && values.is_array() && values.size() == 2;
  return pairs ? json : nlohmann::json(nlohmann::json::value_t::discarded);
}

}  // namespace

std::string OptionChanges(const MapperOptions& before, const MapperOptions& after) {
  const nlohmann::json old = OptionsToJson(before), now = OptionsToJson(after);
  nlohmann::json changes = nlohmann::json::object();
  for (const auto& [name, value] : now.items()) {
    if (value != old.at(name)) changes[name] = {old.at(name), value};
  }
  return changes.empty() ? "" : changes.dump();
}

Status ApplyOptionChanges(std::string_view changes, MapperOptions& options) {
  if (changes.empty()) return {};
  const nlohmann::json json = ParseChanges(changes);
  if (json.is_discarded()) return NotAChange(changes);
  nlohmann::json values = nlohmann::json::object();
  for (const auto& [name, pair] : json.items()) values[name] = pair[1];
  if (const Status status = OptionsFromJson(values, options); !status.ok())
    return Error{ErrorCode::kCorrupt, status.error().message};
  return {};
}

std::string DescribeOptionChanges(std::string_view changes) {
  const nlohmann::json json = ParseChanges(changes);
  std::string line;
  if (json.is_discarded()) return line;
  for (const auto& [name, pair] : json.items()) {
    if (!line.empty()) line += kNext;
    line += name + " " + pair[0].dump() + std::string(kBecomes) + pair[1].dump();
  }
  return line;
}

Result<std::string> OptionChangesFromFormat1(std::string_view line) {
  nlohmann::json changes = nlohmann::json::object();
  while (!line.empty()) {
    const std::size_t end = line.find(kNext);
    const std::string_view part = line.substr(0, end);
    const std::size_t space = part.find(' '), becomes = part.find(kBecomes);
    if (space == std::string_view::npos || becomes == std::string_view::npos || becomes <= space)
      return NotAChange(part);
    const auto before = ParseJson(part.substr(space + 1, becomes - space - 1));
    const auto after = ParseJson(part.substr(becomes + kBecomes.size()));
    if (before.is_discarded() || after.is_discarded()) return NotAChange(part);
    changes[std::string(part.substr(0, space))] = {before, after};
    line = end == std::string_view::npos ? "" : line.substr(end + kNext.size());
  }
  return JsonText(changes);  // a damaged name need not be UTF-8
}

}  // namespace plumbline
