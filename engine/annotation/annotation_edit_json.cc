// SPDX-License-Identifier: Apache-2.0
#include <nlohmann/json.hpp>

#include "engine/annotation/annotation_edit.h"
#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

using nlohmann::json;

json VectorToJson(const Eigen::VectorXd& vector) {
  return std::vector<double>(vector.data(), vector.data() + vector.size());
}

json ToJson(const AddInstance& edit) {
  json result = {{"edit", "add"}, {"instance", InstanceToJson(edit.instance)}};
  if (edit.index) result["index"] = *edit.index;
  return result;
}

json ToJson(const RemoveInstance& edit) { return {{"edit", "remove"}, {"id", edit.id}}; }

json ToJson(const ChangeInstance& edit) {
  json result = {{"edit", "change"}, {"id", edit.id}};
  const auto put = [&](const char* key, const auto& value) {
    if (value) result[key] = *value;
  };
  put("new_id", edit.new_id);
  put("model", edit.model);
  put("category", edit.category);
  put("note", edit.note);
  put("annotator", edit.annotator);
  put("hidden", edit.hidden);
  put("locked", edit.locked);
  put("seconds_spent", edit.seconds_spent);
  if (edit.fine) result["quality"] = *edit.fine ? "fine" : "coarse";
  if (edit.scan_from_object) result["scan_from_object"] = IsometryToJson(*edit.scan_from_object);
  return result;
}

json ToJson(const SetGravity& edit) {
  json result = {{"edit", "gravity"}, {"gravity", VectorToJson(edit.gravity_in_scan)}};
  if (edit.floor_in_scan) result["floor"] = VectorToJson(*edit.floor_in_scan);
  return result;
}

json ToJson(const SetSceneAlignment& edit) {
  json result = {{"edit", "scene_alignment"}};
  if (edit.scan_from_world) result["scan_from_world"] = IsometryToJson(*edit.scan_from_world);
  return result;
}

json ToJson(const SetInputs& edit) {
  return {{"edit", "inputs"},
          {"scan", edit.scan},
          {"models", edit.models},
          {"sequence", edit.sequence}};
}

json ToJson(const AddCrop& edit) {
  json result = {{"edit", "crop"}, {"crop", CropToJson(edit.crop)}};
  if (edit.index) result["index"] = *edit.index;
  return result;
}

json ToJson(const RemoveCrop& edit) { return {{"edit", "remove_crop"}, {"id", edit.id}}; }

json ToJson(const AddPair& edit) {
  json result = {{"edit", "pair"}, {"pair", PairToJson(edit.pair)}};
  if (edit.index) result["index"] = *edit.index;
  return result;
}

json ToJson(const RemovePair& edit) { return {{"edit", "remove_pair"}, {"index", edit.index}}; }

json ToJson(const EditGroup& group) {
  json result = {{"edit", "group"}, {"label", group.label}, {"edits", json::array()}};
  for (const Edit& edit : group.edits) result["edits"].push_back(EditToJson(edit));
  return result;
}

Result<std::optional<std::size_t>> IndexFrom(const json& source) {
  if (!source.contains("index")) return std::optional<std::size_t>();
  if (!source["index"].is_number_unsigned()) return InvalidInput("'index' must be a whole number");
  return std::optional(source["index"].get<std::size_t>());
}

Result<Edit> CropEditFrom(const json& source) {
  if (!source.contains("crop")) return InvalidInput("an edit 'crop' needs a 'crop'");
  Result<Crop> crop = CropFromJson(source["crop"]);
  if (!crop) return crop.error();
  const auto index = IndexFrom(source);
  if (!index) return index.error();
  return Edit(AddCrop{std::move(*crop), *index});
}

Result<Edit> PairEditFrom(const json& source) {
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

Result<Edit> AddFrom(const json& source) {
  if (!source.contains("instance")) return InvalidInput("an edit 'add' needs an 'instance'");
  Result<AnnotatedInstance> instance = InstanceFromJson(source["instance"]);
  if (!instance) return instance.error();
  const auto index = IndexFrom(source);
  if (!index) return index.error();
  return Edit(AddInstance{std::move(*instance), *index});
}

Result<Edit> ChangeFrom(const json& source, const std::string& id) {
  ChangeInstance edit;
  edit.id = id;
  for (const auto& [key, value] : source.items()) {
    const auto text = [&](std::optional<std::string>& field) {
      if (value.is_string()) field = value.get<std::string>();
      return value.is_string();
    };
    const auto flag = [&](std::optional<bool>& field) {
      if (value.is_boolean()) field = value.get<bool>();
      return value.is_boolean();
    };
    bool good = true;
    if (key == "edit" || key == "id") continue;
    if (key == "new_id") {
      good = text(edit.new_id);
    } else if (key == "model") {
      good = text(edit.model);
    } else if (key == "category") {
      good = text(edit.category);
    } else if (key == "note") {
      good = text(edit.note);
    } else if (key == "annotator") {
      good = text(edit.annotator);
    } else if (key == "hidden") {
      good = flag(edit.hidden);
    } else if (key == "locked") {
      good = flag(edit.locked);
    } else if (key == "seconds_spent") {
      good = value.is_number();
      if (good) edit.seconds_spent = value.get<double>();
    } else if (key == "quality") {
      good = value == "fine" || value == "coarse";
      edit.fine = value == "fine";
    } else if (key == "scan_from_object") {
      edit.scan_from_object = IsometryFromJson(value);
      good = edit.scan_from_object.has_value();
    } else {
      return InvalidInput("an edit 'change' knows no '" + key + "'");
    }
    if (!good) return InvalidInput("'" + key + "' of the change of '" + id + "' has a wrong value");
  }
  return Edit(std::move(edit));
}

Result<Edit> GravityFrom(const json& source) {
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

Result<Edit> GroupFrom(const json& source) {
  if (!source.contains("edits") || !source["edits"].is_array()) {
    return InvalidInput("an edit 'group' needs a list 'edits'");
  }
  EditGroup group{TextFromJson(source, "label").value_or("Several edits"), {}};
  for (const json& entry : source["edits"]) {
    Result<Edit> edit = EditFromJson(entry);
    if (!edit) return edit.error();
    group.edits.push_back(std::move(*edit));
  }
  return Edit(std::move(group));
}

}  // namespace

json EditToJson(const Edit& edit) {
  return std::visit([](const auto& chosen) { return ToJson(chosen); }, edit);
}

Result<Edit> EditFromJson(const json& source) {
  const std::string kind = TextFromJson(source, "edit").value_or("");
  if (kind == "add") return AddFrom(source);
  if (kind == "crop") return CropEditFrom(source);
  if (kind == "pair" || kind == "remove_pair") return PairEditFrom(source);
  if (kind == "gravity") return GravityFrom(source);
  if (kind == "group") return GroupFrom(source);
  if (kind == "scene_alignment") {
    if (!source.contains("scan_from_world")) return Edit(SetSceneAlignment{});
    const auto pose = IsometryFromJson(source["scan_from_world"]);
    if (!pose) return InvalidInput("'scan_from_world' is not a 4x4 rigid transform");
    return Edit(SetSceneAlignment{*pose});
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
    return ChangeFrom(source, *id);
  }
  return InvalidInput(
      "an edit needs 'edit': add, remove, change, gravity, scene_alignment, inputs, crop, "
      "remove_crop, pair, remove_pair or group, not '" +
      kind + "'");
}

}  // namespace plumbline
