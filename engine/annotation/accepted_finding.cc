// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/accepted_finding.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

Result<AcceptedFinding::Object> AcceptedObjectFromJson(const nlohmann::json& json) {
  AcceptedFinding::Object object;
  object.id = TextFromJson(json, "id").value_or("");
  object.model = TextFromJson(json, "model").value_or("");
  const auto pose =
      json.contains("scan_from_object") ? IsometryFromJson(json["scan_from_object"]) : std::nullopt;
  if (object.id.empty() || !pose) {
    return InvalidInput("an object of an accepted finding needs an 'id' and a 'scan_from_object'");
  }
  object.scan_from_object = *pose;
  if (json.contains("scale") && json["scale"].is_number()) object.scale = json["scale"];
  return object;
}

}  // namespace

bool AcceptedFinding::IsAbout(const std::string& finding_kind,
                              const std::vector<std::string>& ids) const {
  std::vector<std::string> own;
  for (const Object& object : objects) own.push_back(object.id);
  return kind == finding_kind &&
         std::is_permutation(own.begin(), own.end(), ids.begin(), ids.end());
}

nlohmann::json AcceptedToJson(const AcceptedFinding& accepted) {
  nlohmann::json json = {{"kind", accepted.kind},
                         {"amount", accepted.amount},
                         {"unit", accepted.unit},
                         {"by", accepted.by},
                         {"objects", nlohmann::json::array()}};
  if (!accepted.note.empty()) json["note"] = accepted.note;
  for (const AcceptedFinding::Object& object : accepted.objects) {
    nlohmann::json entry = {{"id", object.id},
                            {"model", object.model},
                            {"scan_from_object", IsometryToJson(object.scan_from_object)}};
    if (object.scale != 1) entry["scale"] = object.scale;
    json["objects"].push_back(std::move(entry));
  }
  return json;
}

Result<AcceptedFinding> AcceptedFromJson(const nlohmann::json& json) {
  if (!json.is_object()) return InvalidInput("an accepted finding must be a JSON object");
  AcceptedFinding accepted;
  accepted.kind = TextFromJson(json, "kind").value_or("");
  accepted.unit = TextFromJson(json, "unit").value_or("");
  accepted.by = TextFromJson(json, "by").value_or("");
  accepted.note = TextFromJson(json, "note").value_or("");
  if (json.contains("amount") && json["amount"].is_number()) accepted.amount = json["amount"];
  const bool listed = json.contains("objects") && json["objects"].is_array();
  if (accepted.kind.empty() || !listed || json["objects"].empty()) {
    return InvalidInput("an accepted finding needs a 'kind' and the 'objects' it is about");
  }
  for (const nlohmann::json& entry : json["objects"]) {
    auto object = AcceptedObjectFromJson(entry);
    if (!object) return object.error();
    accepted.objects.push_back(std::move(*object));
  }
  return accepted;
}

}  // namespace plumbline
