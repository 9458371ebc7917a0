// SPDX-License-Identifier: Apache-2.0
#include <numbers>

#include <nlohmann/json.hpp>

#include "engine/dataset/json_fields.h"
#include "engine/evaluation/map_evaluation.h"
#include "engine/evaluation/surface_references.h"

namespace plumbline {
namespace {

double Degrees(double radians) { return radians * 180.0 / std::numbers::pi; }

nlohmann::json ToJson(const ErrorStatistics& s) {
  if (s.samples == 0) {
    return {{"mean_m", nullptr},
            {"median_m", nullptr},
            {"std_m", nullptr},
            {"max_m", nullptr},
            {"samples", 0}};
  }
  return {{"mean_m", s.mean_m},
          {"median_m", s.median_m},
          {"std_m", s.std_m},
          {"max_m", s.max_m},
          {"samples", s.samples}};
}

nlohmann::json ToJson(const SurfaceDistance& distance) {
  nlohmann::json json = ToJson(distance.to_triangle);
  json["to_plane"] = ToJson(distance.to_plane);
  return json;
}

nlohmann::json MeanOrNull(const ErrorStatistics& s) {
  return s.samples > 0 ? nlohmann::json(s.mean_m) : nullptr;
}

nlohmann::json ToJson(const MatchedObject& object) {
  const PoseError& pose = object.pose;
  nlohmann::json json = {
      {"id", object.estimate.id},
      {"model", object.estimate.model},
      {"ground_truth", object.truth.id},
      {"quality", object.truth.fine ? "fine" : "coarse"},
      {"model_correct", object.model_correct},
      {"translation_m", pose.translation_m},
      {"rotation_deg", Degrees(pose.rotation_rad)},
      {"azimuth_deg", pose.azimuth_rad ? nlohmann::json(Degrees(*pose.azimuth_rad)) : nullptr},
      {"tilt_deg", Degrees(pose.tilt_rad)},
      {"height_m", pose.height_m},
      {"centre_m", object.centre_m},
      {"surface_mean_m", MeanOrNull(object.surface)}};
  json["add_m"] = object.add ? nlohmann::json(object.add->add_m) : nullptr;
  json["add_s_m"] = object.add ? nlohmann::json(object.add->add_s_m) : nullptr;
  if (object.estimate.scale_std) {
    json["scale"] = object.estimate.scale;
    json["scale_std"] = *object.estimate.scale_std;
  }
  if (object.truth.scale != 1) json["true_scale"] = object.truth.scale;
  const TruthDeviation known = DeviationOf(object.truth);
  json["truth_position_std_m"] = known.position_m;
  json["truth_azimuth_std_deg"] = Degrees(known.azimuth_rad);
  return json;
}

nlohmann::json ToJson(const MeanPoseError& mean) {
  return {
      {"mean_translation_m", mean.translation_m ? nlohmann::json(*mean.translation_m) : nullptr},
      {"mean_rotation_deg",
       mean.rotation_rad ? nlohmann::json(Degrees(*mean.rotation_rad)) : nullptr}};
}

}  // namespace

nlohmann::json EvaluationToJson(const MapEvaluation& evaluation, const EvaluationOptions& options) {
  nlohmann::json objects = nlohmann::json::array();
  for (const MatchedObject& object : evaluation.matched) objects.push_back(ToJson(object));
  nlohmann::json spurious = nlohmann::json::array();
  for (const SpuriousObject& object : evaluation.spurious) {
    spurious.push_back({{"id", object.estimate.id},
                        {"model", object.estimate.model},
                        {"category", object.estimate.category},
                        {"surface_mean_m", MeanOrNull(object.surface)}});
    if (!object.moving.empty()) spurious.back()["moving"] = object.moving;
  }
  nlohmann::json missed = nlohmann::json::array();
  for (const GroundTruthInstance& instance : evaluation.missed) {
    missed.push_back({{"ground_truth", instance.id},
                      {"model", instance.model},
                      {"category", instance.category},
                      {"quality", instance.fine ? "fine" : "coarse"}});
  }
  nlohmann::json json = {
      {"alignment", IsometryToJson(evaluation.truth_from_estimate)},
      {"surface", ToJson(evaluation.surface)},
      {"surface_normal", ToJson(evaluation.surface_normal)},
      {"completeness", ToJson(evaluation.completeness)},
      {"objects", std::move(objects)},
      {"matched", evaluation.matched.size()},
      {"missed", evaluation.missed.size()},
      {"spurious", evaluation.spurious.size()},
      {"all", ToJson(evaluation.mean_all)},
      {"missed_instances", std::move(missed)},
      {"spurious_objects", std::move(spurious)},
      {"settings",
       {{"align", EnumNames<Alignment>::names[static_cast<std::size_t>(options.align)]},
        {"truth", EnumNames<TruthSurface>::names[static_cast<std::size_t>(options.truth)]},
        {"ignored_categories", options.ignored_categories},
        {"match_distance_m", options.match_distance_m},
        {"samples", options.samples},
        {"seed", options.seed}}}};
  json.update(ToJson(evaluation.mean));
  return json;
}

nlohmann::json SurfacesToJson(const SurfaceReferences& references) {
  nlohmann::json json = {{"scanned", nullptr},
                         {"posed", ToJson(references.posed)},
                         {"paper", nullptr},
                         {"visma", nullptr}};
  if (references.scanned) {
    json["scanned"] = ToJson(references.scanned->distance);
    json["scanned"]["share"] = references.scanned->share;
  }
  if (references.paper) {
    json["paper"] = ToJson(references.paper->distance);
    json["paper"]["alignment"] = IsometryToJson(references.paper->truth_from_estimate);
    json["paper"]["matched"] = references.paper->matched;
    json["paper"].update(ToJson(references.paper->mean));
    json["paper"]["all"] = ToJson(references.paper->mean_all);
  }
  if (references.visma) json["visma"] = ToJson(*references.visma);
  return json;
}

}  // namespace plumbline
