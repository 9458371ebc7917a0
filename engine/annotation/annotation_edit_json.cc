// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "engine/annotation/annotation_edit.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

nlohmann::json VectorToJson(const Eigen::VectorXd& vector) {
  return std::vector<double>(vector.data(), vector.data() + vector.size());
}

nlohmann::json ToJson(const AddInstance& edit) {
  nlohmann::json result = {{"edit", "add"}, {"instance", InstanceToJson(edit.instance)}};
  if (edit.index) result["index"] = *edit.index;
  return result;
}

nlohmann::json ToJson(const RemoveInstance& edit) { return {{"edit", "remove"}, {"id", edit.id}}; }

nlohmann::json ToJson(const ChangeInstance& edit) {
  nlohmann::json result = ChangeToJson(edit.set);
  result["edit"] = "change";
  result["id"] = edit.id;
  return result;
}

nlohmann::json ToJson(const SetGravity& edit) {
  nlohmann::json result = {{"edit", "gravity"}, {"gravity", VectorToJson(edit.gravity_in_scan)}};
  if (edit.floor_in_scan) result["floor"] = VectorToJson(*edit.floor_in_scan);
  return result;
}

nlohmann::json ToJson(const SetSceneAlignment& edit) {
  nlohmann::json result = {{"edit", "scene_alignment"}};
  if (edit.scan_from_world) result["scan_from_world"] = IsometryToJson(*edit.scan_from_world);
  return result;
}

nlohmann::json ToJson(const SetInputs& edit) {
  return {{"edit", "inputs"},
          {"scan", edit.scan},
          {"models", edit.models},
          {"sequence", edit.sequence}};
}

nlohmann::json ToJson(const AddCrop& edit) {
  nlohmann::json result = {{"edit", "crop"}, {"crop", CropToJson(edit.crop)}};
  if (edit.index) result["index"] = *edit.index;
  return result;
}

nlohmann::json ToJson(const RemoveCrop& edit) { return {{"edit", "remove_crop"}, {"id", edit.id}}; }

nlohmann::json ToJson(const AddPair& edit) {
  nlohmann::json result = {{"edit", "pair"}, {"pair", PairToJson(edit.pair)}};
  if (edit.index) result["index"] = *edit.index;
  return result;
}

nlohmann::json ToJson(const RemovePair& edit) {
  return {{"edit", "remove_pair"}, {"index", edit.index}};
}

nlohmann::json ToJson(const SetState& edit) {
  nlohmann::json result = {{"edit", "state"}};
  if (edit.state) result["state"] = StateToJson(*edit.state);
  return result;
}

nlohmann::json ToJson(const AcceptFinding& edit) {
  nlohmann::json result = {{"edit", "accept"}, {"finding", AcceptedToJson(edit.accepted)}};
  if (edit.index) result["index"] = *edit.index;
  return result;
}

nlohmann::json ToJson(const ReopenFinding& edit) {
  return {{"edit", "reopen"}, {"kind", edit.kind}, {"instances", edit.instances}};
}

nlohmann::json ToJson(const EditGroup& group) {
  nlohmann::json result = {
      {"edit", "group"}, {"label", group.label}, {"edits", nlohmann::json::array()}};
  for (const Edit& edit : group.edits) result["edits"].push_back(EditToJson(edit));
  return result;
}

Result<std::optional<std::size_t>> IndexFrom(const nlohmann::json& source) {
  if (!source.contains("index")) return std::optional<std::size_t>();
  if (!source["index"].is_number_unsigned()) return InvalidInput("'index' must be a whole number");
  return std::optional(source["index"].get<std::size_t>());
}

Result<Edit> CropEditFrom(const nlohmann::json& source) {
  if (!source.contains("crop")) return InvalidInput("an edit 'crop' needs a 'crop'");
  Result<Crop> crop = CropFromJson(source["crop"]);
  if (!crop) return crop.error();
  const auto index = IndexFrom(source);
  if (!index) return index.error();
  return Edit(AddCrop{std::move(*crop), *index});
}

Result<Edit> PairEditFrom(const nlohmann::json& source) {
  const auto index = IndexFrom(source);
  if (!index) return index.error();
  if (source["edit"] == "remove_pair") {
    if (!*index) return InvalidInput("an edit 'remove_pair' needs an 'index'");
    return Edit(RemovePair{**index});
  }
  if (!source.contains("pair")) return InvalidInput("an edit 'pair' needs a 'pair'");
  const Result<FramePick> pair = PairFromJson(source["pair"]);
  if (!pair) return pair.error();
  return Edit(AddPair{*pair, *index});
}

Result<Edit> AddFrom(const nlohmann::json& source) {
  if (!source.contains("instance")) return InvalidInput("an edit 'add' needs an 'instance'");
  Result<AnnotatedInstance> instance = InstanceFromJson(source["instance"]);
  if (!instance) return instance.error();
  const auto index = IndexFrom(source);
  if (!index) return index.error();
  return Edit(AddInstance{std::move(*instance), *index});
}

Result<Edit> GravityFrom(const nlohmann::json& source) {
  const auto gravity =
      source.contains("gravity") ? VectorFromJson(source["gravity"], 3) : std::nullopt;
  if (!gravity || !(gravity->norm() > 1e-6)) {
    return InvalidInput("an edit 'gravity' needs 'gravity', three numbers that point down");
  }
  const double norm = gravity->norm();
  SetGravity edit{std::abs(norm - 1) < 1e-12 ? *gravity : *gravity / norm, std::nullopt};
  if (source.contains("floor")) {
    const auto floor = VectorFromJson(source["floor"], 4);
    if (!floor) return InvalidInput("'floor' must be four numbers");
    edit.floor_in_scan = *floor;
  }
  return Edit(std::move(edit));
}

Result<Edit> AcceptFrom(const nlohmann::json& source) {
  if (!source.contains("finding")) return InvalidInput("an edit 'accept' needs a 'finding'");
  Result<AcceptedFinding> accepted = AcceptedFromJson(source["finding"]);
  if (!accepted) return accepted.error();
  const auto index = IndexFrom(source);
  if (!index) return index.error();
  return Edit(AcceptFinding{std::move(*accepted), *index});
}

Result<Edit> ReopenFrom(const nlohmann::json& source) {
  ReopenFinding edit{TextFromJson(source, "kind").value_or(""), {}};
  for (const nlohmann::json& id : source.value("instances", nlohmann::json::array())) {
    if (id.is_string()) edit.instances.push_back(id);
  }
  if (edit.kind.empty() || edit.instances.empty()) {
    return InvalidInput("an edit 'reopen' needs a 'kind' and 'instances'");
  }
  return Edit(std::move(edit));
}

Result<Edit> GroupFrom(const nlohmann::json& source) {
  if (!source.contains("edits") || !source["edits"].is_array()) {
    return InvalidInput("an edit 'group' needs a list 'edits'");
  }
  EditGroup group{TextFromJson(source, "label").value_or("Several edits"), {}};
  for (const nlohmann::json& entry : source["edits"]) {
    Result<Edit> edit = EditFromJson(entry);
    if (!edit) return edit.error();
    group.edits.push_back(std::move(*edit));
  }
  return Edit(std::move(group));
}

}  // namespace

nlohmann::json EditToJson(const Edit& edit) {
  return std::visit([](const auto& chosen) { return ToJson(chosen); }, edit);
}

Result<Edit> EditFromJson(const nlohmann::json& source) {
  const std::string kind = TextFromJson(source, "edit").value_or("");
  if (kind == "add") return AddFrom(source);
  if (kind == "crop") return CropEditFrom(source);
  if (kind == "pair" || kind == "remove_pair") return PairEditFrom(source);
  if (kind == "gravity") return GravityFrom(source);
  if (kind == "group") return GroupFrom(source);
  if (kind == "accept") return AcceptFrom(source);
  if (kind == "reopen") return ReopenFrom(source);
  if (kind == "scene_alignment") {
    if (!source.contains("scan_from_world")) return Edit(SetSceneAlignment{});
    const auto pose = IsometryFromJson(source["scan_from_world"]);
    if (!pose) return InvalidInput("'scan_from_world' is not a 4x4 rigid transform within 1000 km");
    return Edit(SetSceneAlignment{*pose});
  }
  if (kind == "state") {
    if (!source.contains("state")) return Edit(SetState{});
    Result<ProjectState> state = StateFromJson(source["state"]);
    if (!state) return state.error();
    return Edit(SetState{std::move(*state)});
  }
  if (kind == "inputs") {
    return Edit(SetInputs{TextFromJson(source, "scan").value_or(""),
                          TextFromJson(source, "models").value_or(""),
                          TextFromJson(source, "sequence").value_or("")});
  }
  if (kind == "remove" || kind == "change" || kind == "remove_crop") {
    const auto id = TextFromJson(source, "id");
    if (!id) return InvalidInput("an edit '" + kind + "' needs an 'id'");
    if (kind == "remove_crop") return Edit(RemoveCrop{*id});
    if (kind == "remove") return Edit(RemoveInstance{*id});
    Result<InstanceChange> change = ChangeFromJson(source);
    if (!change) return change.error();
    return Edit(ChangeInstance{*id, std::move(*change)});
  }
  return InvalidInput(
      "an edit needs 'edit': add, remove, change, gravity, scene_alignment, inputs, crop, "
      "remove_crop, pair, remove_pair, state, accept, reopen or group, not '" +
      kind + "'");
}

}  // namespace plumbline
