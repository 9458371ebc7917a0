// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/annotation_document.h"

#include <algorithm>
#include <set>

#include <nlohmann/json.hpp>

#include "engine/dataset/json_fields.h"
#include "engine/geometry/gravity.h"

namespace plumbline {
namespace {

std::vector<double> ListOf(const Eigen::VectorXd& vector) {
  return {vector.data(), vector.data() + vector.size()};
}

}  // namespace

const AnnotatedInstance* AnnotationDocument::Find(const std::string& id) const {
  const auto found = std::find_if(instances.begin(), instances.end(),
                                  [&](const auto& instance) { return instance.id == id; });
  return found == instances.end() ? nullptr : &*found;
}

std::string AnnotationDocument::FreeId(const std::string& model) const {
  for (int i = 0;; ++i) {
    std::string id = model + "_" + std::to_string(i);
    if (Find(id) == nullptr) return id;
  }
}

const Crop* AnnotationDocument::FindCrop(const std::string& id) const {
  const auto found =
      std::find_if(crops.begin(), crops.end(), [&](const auto& crop) { return crop.id == id; });
  return found == crops.end() ? nullptr : &*found;
}

int AnnotationDocument::NumFragments() const {
  return static_cast<int>(std::count_if(crops.begin(), crops.end(), [](const Crop& crop) {
    return crop.into == Crop::Into::kFragment;
  }));
}

WorkStage AnnotationDocument::Stage() const {
  if (state) return state->stage;
  return instances.empty() && crops.empty() ? WorkStage::kNew : WorkStage::kInWork;
}

Eigen::Isometry3d AnnotationDocument::LevelFromScan() const {
  Eigen::Isometry3d level_from_scan = Eigen::Isometry3d::Identity();
  level_from_scan.linear() = UprightFrame(gravity_in_scan).upright_rotation().transpose();
  if (floor_in_scan) level_from_scan.translation().z() = (*floor_in_scan)[3];
  return level_from_scan;
}

nlohmann::json PairToJson(const FramePick& pair) {
  return {{"in_scan", {pair.in_scan.x(), pair.in_scan.y(), pair.in_scan.z()}},
          {"frame", pair.frame},
          {"pixel", {pair.pixel.x(), pair.pixel.y()}}};
}

Result<FramePick> PairFromJson(const nlohmann::json& json) {
  const auto numbers = [&](const char* key, int count) {
    return json.is_object() && json.contains(key) ? VectorFromJson(json[key], count) : std::nullopt;
  };
  const auto in_scan = numbers("in_scan", 3), pixel = numbers("pixel", 2);
  const int frame = json.is_object() && json.contains("frame") && json["frame"].is_number_integer()
                        ? json["frame"].get<int>()
                        : -1;
  if (!in_scan || !pixel || frame < 0) {
    return InvalidInput("a pair needs 'in_scan' [x, y, z], a 'frame' and its 'pixel' [u, v]");
  }
  return FramePick{*in_scan, frame, *pixel};
}

nlohmann::json DocumentToJson(const AnnotationDocument& document) {
  nlohmann::json json = {
      {"plumbline_annotation", 1},
      {"conventions",
       "metres; scan_from_object takes object coordinates to the scan file's own frame, rows; "
       "gravity points down"},
      {"scan", document.scan},
      {"models", document.models},
      {"sequence", document.sequence},
      {"gravity", ListOf(document.gravity_in_scan)},
      {"instances", nlohmann::json::array()}};
  if (document.floor_in_scan) json["floor"] = ListOf(*document.floor_in_scan);
  if (document.scan_from_world) json["scan_from_world"] = IsometryToJson(*document.scan_from_world);
  for (const AnnotatedInstance& instance : document.instances) {
    json["instances"].push_back(InstanceToJson(instance));
  }
  for (const Crop& crop : document.crops) json["crops"].push_back(CropToJson(crop));
  for (const FramePick& pair : document.pairs) json["pairs"].push_back(PairToJson(pair));
  if (document.state) json["state"] = StateToJson(*document.state);
  for (const AcceptedFinding& accepted : document.accepted) {
    json["accepted"].push_back(AcceptedToJson(accepted));
  }
  return json;
}

Result<AnnotationDocument> DocumentFromJson(const nlohmann::json& json) {
  if (!json.is_object() || !json.contains("plumbline_annotation")) {
    return InvalidInput("is not an annotation project: it has no 'plumbline_annotation'");
  }
  if (json["plumbline_annotation"] != 1) {
    return Error{ErrorCode::kUnsupported, "was written by a newer Plumbline (version " +
                                              json["plumbline_annotation"].dump() +
                                              "); update this one"};
  }
  AnnotationDocument document;
  document.scan = TextFromJson(json, "scan").value_or("");
  document.models = TextFromJson(json, "models").value_or("");
  document.sequence = TextFromJson(json, "sequence").value_or("");
  if (json.contains("gravity")) {
    const auto gravity = VectorFromJson(json["gravity"], 3);
    if (!gravity || !(gravity->norm() > 1e-6))
      return InvalidInput("has a 'gravity' without direction");
    // A unit vector to rounding stays as it is: reading and writing changes no digit.
    const double norm = gravity->norm();
    document.gravity_in_scan = std::abs(norm - 1) < 1e-12 ? *gravity : *gravity / norm;
  }
  if (json.contains("floor")) {
    const auto floor = VectorFromJson(json["floor"], 4);
    if (!floor) return InvalidInput("has a 'floor' that is not four numbers");
    document.floor_in_scan = *floor;
  }
  if (json.contains("scan_from_world")) {
    const auto pose = IsometryFromJson(json["scan_from_world"]);
    if (!pose)
      return InvalidInput(
          "has a 'scan_from_world' that is not a 4x4 rigid transform within 1000 km");
    document.scan_from_world = *pose;
  }
  if (!json.contains("instances") || !json["instances"].is_array()) {
    return InvalidInput("needs a list 'instances'");
  }
  std::set<std::string> ids;
  for (const nlohmann::json& entry : json["instances"]) {
    Result<AnnotatedInstance> instance = InstanceFromJson(entry);
    if (!instance) return instance.error();
    if (!ids.insert(instance->id).second) {
      return InvalidInput("has two instances with the id '" + instance->id + "'");
    }
    document.instances.push_back(std::move(*instance));
  }
  ids.clear();
  for (const nlohmann::json& entry : json.value("crops", nlohmann::json::array())) {
    Result<Crop> crop = CropFromJson(entry);
    if (!crop) return crop.error();
    if (!ids.insert(crop->id).second) {
      return InvalidInput("has two crops with the id '" + crop->id + "'");
    }
    document.crops.push_back(std::move(*crop));
  }
  for (const nlohmann::json& entry : json.value("pairs", nlohmann::json::array())) {
    const Result<FramePick> pair = PairFromJson(entry);
    if (!pair) return pair.error();
    document.pairs.push_back(*pair);
  }
  if (json.contains("state")) {
    Result<ProjectState> state = StateFromJson(json["state"]);
    if (!state) return state.error();
    document.state = std::move(*state);
  }
  for (const nlohmann::json& entry : json.value("accepted", nlohmann::json::array())) {
    Result<AcceptedFinding> accepted = AcceptedFromJson(entry);
    if (!accepted) return accepted.error();
    document.accepted.push_back(std::move(*accepted));
  }
  return document;
}

}  // namespace plumbline
