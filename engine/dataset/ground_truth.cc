// SPDX-License-Identifier: Apache-2.0
#include "engine/dataset/ground_truth.h"

#include <nlohmann/json.hpp>
#include <set>
#include <string_view>

#include "engine/base/files.h"
#include "engine/dataset/json_fields.h"
#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

std::optional<Eigen::Vector3d> SizeFromJson(const nlohmann::json& json) {
  const std::optional<Eigen::VectorXd> size = VectorFromJson(json, 3);
  if (!size || !(size->minCoeff() > 0 && size->maxCoeff() < 1000)) return std::nullopt;
  return Eigen::Vector3d(*size);
}

/// The instance, or what is wrong with it.
Result<GroundTruthInstance> ReadInstance(const nlohmann::json& json, const std::string& where) {
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, where + " " + what};
  };
  GroundTruthInstance instance;
  const std::optional<std::string> id = TextFromJson(json, "id");
  const std::optional<std::string> model = TextFromJson(json, "model");
  const std::optional<std::string> category = TextFromJson(json, "category");
  if (!id || !model || !category) return bad("needs texts 'id', 'model' and 'category'");
  instance.id = *id;
  instance.model = *model;
  instance.category = *category;
  if (!json.contains("world_from_object")) return bad("(" + *id + ") has no 'world_from_object'");
  const std::optional<Eigen::Isometry3d> pose = IsometryFromJson(json["world_from_object"]);
  if (!pose)
    return bad("(" + *id +
               ") has a 'world_from_object' that is not a 4x4 rigid transform within 1000 km");
  instance.world_from_object = *pose;
  if (json.contains("scale")) {
    if (!json["scale"].is_number() || !(json["scale"] > 0.1 && json["scale"] < 10))
      return bad("(" + *id + ") has a 'scale' that is not a number between 0.1 and 10");
    instance.scale = json["scale"];
  }
  if (json.contains("size_m")) {
    instance.size_m = SizeFromJson(json["size_m"]);
    if (!instance.size_m)
      return bad("(" + *id + ") has a 'size_m' that is not three lengths of less than 1000 m");
  }
  const std::string quality =
      json.contains("quality") ? TextFromJson(json, "quality").value_or("") : "fine";
  if (quality != "fine" && quality != "coarse")
    return bad("(" + *id + ") has a 'quality' that is neither fine nor coarse");
  instance.fine = quality == "fine";
  for (const char* key : {"position_std_m", "azimuth_std_deg"}) {
    if (!json.contains(key)) continue;
    if (!json[key].is_number() || !(json[key].get<double>() >= 0))
      return bad("(" + *id + ") has a '" + key + "' that is not a number from 0 on");
    const double value = json[key];
    if (key == std::string_view("position_std_m"))
      instance.position_std_m = value;
    else
      instance.azimuth_std_rad = value * kRadPerDeg;
  }
  return instance;
}

Result<MovingThing> ReadMoving(const nlohmann::json& json, const std::string& where) {
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, where + " " + what};
  };
  MovingThing thing;
  const std::optional<std::string> id = TextFromJson(json, "id");
  const std::optional<std::string> category = TextFromJson(json, "category");
  if (!id || !category) return bad("needs texts 'id' and 'category'");
  thing.id = *id;
  thing.category = *category;
  const auto size = json.contains("size_m") ? SizeFromJson(json["size_m"]) : std::nullopt;
  if (!size) return bad("(" + *id + ") needs a 'size_m' of three lengths of less than 1000 m");
  thing.size_m = *size;
  if (!json.contains("poses") || !json["poses"].is_array())
    return bad("(" + *id + ") needs a list 'poses'");
  for (const nlohmann::json& entry : json["poses"]) {
    const bool whole = entry.is_object() && entry.contains("frame") &&
                       entry["frame"].is_number_integer() && entry.contains("world_from_object");
    const auto pose = whole ? IsometryFromJson(entry["world_from_object"]) : std::nullopt;
    if (!pose)
      return bad("(" + *id +
                 ") has a pose without a whole 'frame' and a 4x4 rigid 'world_from_object'");
    thing.places.push_back({entry["frame"].get<int>(), *pose});
  }
  return thing;
}

nlohmann::json MovingToJson(const MovingThing& thing) {
  nlohmann::json poses = nlohmann::json::array();
  for (const MovingThing::Place& place : thing.places)
    poses.push_back(
        {{"frame", place.frame}, {"world_from_object", IsometryToJson(place.world_from_object)}});
  return {{"id", thing.id},
          {"category", thing.category},
          {"size_m", {thing.size_m.x(), thing.size_m.y(), thing.size_m.z()}},
          {"poses", std::move(poses)}};
}

nlohmann::json InstanceToJson(const GroundTruthInstance& instance) {
  nlohmann::json json = {{"id", instance.id},
                         {"model", instance.model},
                         {"category", instance.category},
                         {"quality", instance.fine ? "fine" : "coarse"},
                         {"world_from_object", IsometryToJson(instance.world_from_object)}};
  if (instance.scale != 1) json["scale"] = instance.scale;
  if (instance.size_m)
    json["size_m"] = {instance.size_m->x(), instance.size_m->y(), instance.size_m->z()};
  if (instance.position_std_m) json["position_std_m"] = *instance.position_std_m;
  if (instance.azimuth_std_rad) json["azimuth_std_deg"] = *instance.azimuth_std_rad * kDegPerRad;
  return json;
}

}  // namespace

TruthDeviation DeviationOf(const GroundTruthInstance& instance) {
  const TruthDeviation usual =
      instance.fine ? TruthDeviation{0.015, 1 * kRadPerDeg} : TruthDeviation{0.03, 3 * kRadPerDeg};
  return {instance.position_std_m.value_or(usual.position_m),
          instance.azimuth_std_rad.value_or(usual.azimuth_rad)};
}

Result<GroundTruth> ReadGroundTruth(const std::filesystem::path& file) {
  const Result<nlohmann::json> read = ReadJson(file);
  if (!read.ok()) return read.error();
  const nlohmann::json& json = read.value();
  const auto bad = [&](const std::string& what) {
    return Error{ErrorCode::kInvalidInput, "the ground truth '" + file.string() + "' " + what};
  };
  if (!json.is_object() || !json.contains("gravity") || !json.contains("instances") ||
      !json["instances"].is_array()) {
    return bad("needs 'gravity' and a list 'instances'");
  }
  GroundTruth truth;
  const std::optional<Eigen::VectorXd> gravity = VectorFromJson(json["gravity"], 3);
  if (!gravity || !(gravity->norm() > 1e-6 && gravity->norm() < 1e6))
    return bad("has a 'gravity' that is not a direction of three numbers");
  truth.gravity_in_world = gravity->normalized();
  std::set<std::string> ids;
  for (const nlohmann::json& entry : json["instances"]) {
    const std::string where =
        "'" + file.string() + "': instance " + std::to_string(truth.instances.size());
    Result<GroundTruthInstance> instance = ReadInstance(entry, where);
    if (!instance.ok()) return instance.error();
    if (!ids.insert(instance->id).second)
      return bad("has two instances with the id '" + instance->id + "'");
    truth.instances.push_back(std::move(instance).value());
  }
  if (!json.contains("moving")) return truth;
  if (!json["moving"].is_array()) return bad("has 'moving' that is not a list");
  for (const nlohmann::json& entry : json["moving"]) {
    const std::string where =
        "'" + file.string() + "': moving thing " + std::to_string(truth.moving.size());
    Result<MovingThing> thing = ReadMoving(entry, where);
    if (!thing.ok()) return thing.error();
    if (!ids.insert(thing->id).second) return bad("has two things with the id '" + thing->id + "'");
    truth.moving.push_back(std::move(thing).value());
  }
  return truth;
}

Status WriteGroundTruth(const std::filesystem::path& file, const GroundTruth& truth) {
  const Eigen::Vector3d& g = truth.gravity_in_world;
  nlohmann::json json = {{"gravity", {g.x(), g.y(), g.z()}},
                         {"instances", nlohmann::json::array()}};
  for (const GroundTruthInstance& instance : truth.instances) {
    json["instances"].push_back(InstanceToJson(instance));
  }
  for (const MovingThing& thing : truth.moving) json["moving"].push_back(MovingToJson(thing));
  return WriteJson(file, json);
}

}  // namespace plumbline
