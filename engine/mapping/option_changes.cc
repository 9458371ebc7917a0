// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/option_changes.h"

namespace plumbline {
namespace {

constexpr std::string_view kBecomes = " -> ", kNext = "; ";

Error Wrong(std::string_view part) {
  return {ErrorCode::kCorrupt, "'" + std::string(part) + "' is not a change of an option"};
}

}  // namespace

std::string DescribeOptionChanges(const MapperOptions& before, const MapperOptions& after) {
  const nlohmann::json old = OptionsToJson(before), now = OptionsToJson(after);
  std::string line;
  for (const auto& [name, value] : now.items()) {
    if (value == old.at(name)) continue;
    if (!line.empty()) line += kNext;
    line += name + " " + old.at(name).dump() + std::string(kBecomes) + value.dump();
  }
  return line;
}

Status ApplyOptionChanges(std::string_view line, MapperOptions& options) {
  nlohmann::json changes = nlohmann::json::object();
  while (!line.empty()) {
    const std::size_t end = line.find(kNext);
    const std::string_view part = line.substr(0, end);
    const std::size_t space = part.find(' '), becomes = part.find(kBecomes);
    if (space == std::string_view::npos || becomes == std::string_view::npos) return Wrong(part);
    const auto value =
        nlohmann::json::parse(part.substr(becomes + kBecomes.size()), nullptr, false);
    if (value.is_discarded()) return Wrong(part);
    changes[std::string(part.substr(0, space))] = value;
    line = end == std::string_view::npos ? "" : line.substr(end + kNext.size());
  }
  if (const Status status = OptionsFromJson(changes, options); !status.ok())
    return Error{ErrorCode::kCorrupt, status.error().message};
  return {};
}

}  // namespace plumbline
