// SPDX-License-Identifier: Apache-2.0
#include "engine/vision/two_stage_sidecar.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

using TwoStageProblem = std::optional<std::string>;

/// A number of a part of the sidecar, within [low, high].
template <typename T>
struct BoundedField {
  const char* key;
  T* value;
  T low, high;
};

template <typename T>
TwoStageProblem ReadBounded(const nlohmann::json& part, const std::string& name,
                            const BoundedField<T>& field) {
  constexpr bool kWhole = std::is_integral_v<T>;
  const nlohmann::json::const_iterator found = part.find(field.key);
  const bool number = found != part.end() &&
                      (kWhole ? found->is_number_integer() : found->is_number()) &&
                      found->get<double>() >= static_cast<double>(field.low) &&
                      found->get<double>() <= static_cast<double>(field.high);
  if (!number) {
    return "needs a " + std::string(kWhole ? "whole number" : "number") + " '" + name + "." +
           field.key + "' of " + nlohmann::json(field.low).dump() + " to " +
           nlohmann::json(field.high).dump();
  }
  *field.value = found->get<T>();
  return std::nullopt;
}

TwoStageProblem ReadBoxWeights(const nlohmann::json& part, const std::string& name,
                               std::array<float, 4>& weights) {
  const auto found = part.find("weights");
  const auto four = found == part.end() ? std::nullopt : VectorFromJson(*found, 4);
  if (!four || four->minCoeff() <= 0) return "needs four positive numbers '" + name + ".weights'";
  for (int i = 0; i < 4; ++i) weights[i] = static_cast<float>((*four)[i]);
  return std::nullopt;
}

/// Positive numbers; empty if they are none.
std::vector<float> PositiveNumbers(const nlohmann::json& object, const char* key) {
  std::vector<float> numbers;
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array()) return {};
  for (const nlohmann::json& number : *found) {
    if (!number.is_number() || number.get<float>() <= 0) return {};
    numbers.push_back(number.get<float>());
  }
  return numbers;
}

TwoStageProblem ReadAnchors(const nlohmann::json& sidecar, std::size_t levels,
                            std::vector<AnchorSettings>& anchors) {
  const std::string wanted =
      "needs its 'anchors': {\"sizes\": [..], \"ratios\": [..]} for each of its " +
      std::to_string(levels) + " strides";
  const auto found = sidecar.find("anchors");
  if (found == sidecar.end() || !found->is_array() || found->size() != levels) return wanted;
  for (const nlohmann::json& level : *found) {
    if (!level.is_object()) return wanted;
    AnchorSettings settings{PositiveNumbers(level, "sizes"), PositiveNumbers(level, "ratios")};
    if (settings.count() == 0) return wanted;
    anchors.push_back(std::move(settings));
  }
  return std::nullopt;
}

/// The object under `key`; an empty one, which lacks all that it must have, where there is none.
nlohmann::json PartOf(const nlohmann::json& sidecar, const char* key) {
  const auto found = sidecar.find(key);
  return found != sidecar.end() && found->is_object() ? *found : nlohmann::json::object();
}

}  // namespace

std::optional<std::string> ReadTwoStage(const nlohmann::json& sidecar, std::size_t levels,
                                        TwoStageSettings& s) {
  if (levels == 0) return "needs its 'strides', one a level";
  TwoStageProblem problem = ReadAnchors(sidecar, levels, s.anchors);
  const nlohmann::json rpn = PartOf(sidecar, "rpn"), crops = PartOf(sidecar, "crops"),
                       boxes = PartOf(sidecar, "boxes");
  const int most_levels = static_cast<int>(levels);
  const auto whole = [&](const nlohmann::json& part, const char* name, const char* key, int& value,
                         int low, int high) {
    if (!problem) problem = ReadBounded<int>(part, name, {key, &value, low, high});
  };
  const auto real = [&](const nlohmann::json& part, const char* name, const char* key, float& value,
                        float low, float high) {
    if (!problem) problem = ReadBounded<float>(part, name, {key, &value, low, high});
  };
  whole(rpn, "rpn", "before_nms", s.proposals_before_nms, 1, 100000);
  whole(rpn, "rpn", "after_nms", s.proposals_after_nms, 1, 100000);
  real(rpn, "rpn", "nms_iou", s.proposal_nms_iou, 0, 1);
  real(rpn, "rpn", "min_score", s.proposal_min_score, 0, 1);
  if (!problem) problem = ReadBoxWeights(rpn, "rpn", s.proposal_weights);
  whole(crops, "crops", "size", s.crop_size, 1, 64);
  whole(crops, "crops", "sampling", s.crop_sampling, 0, 16);
  whole(crops, "crops", "levels", s.crop_levels, 1, most_levels);
  if (!problem && crops.contains("columns")) {
    if (!crops["columns"].is_boolean())
      return "has a 'crops.columns' that is neither true nor false";
    s.crop_columns = crops["columns"].get<bool>();
  }
  real(crops, "crops", "canonical_scale", s.canonical_scale, 1, 8192);
  whole(crops, "crops", "canonical_level", s.canonical_level, 0, 16);
  if (!problem) problem = ReadBoxWeights(boxes, "boxes", s.box_weights);
  whole(boxes, "boxes", "most", s.most_boxes, 1, 100000);
  return problem;
}

void WriteTwoStage(const TwoStageSettings& s, nlohmann::json& sidecar) {
  sidecar["anchors"] = nlohmann::json::array();
  for (const AnchorSettings& level : s.anchors)
    sidecar["anchors"].push_back({{"sizes", level.sizes}, {"ratios", level.ratios}});
  sidecar["rpn"] = {{"before_nms", s.proposals_before_nms},
                    {"after_nms", s.proposals_after_nms},
                    {"nms_iou", s.proposal_nms_iou},
                    {"min_score", s.proposal_min_score},
                    {"weights", s.proposal_weights}};
  sidecar["crops"] = {{"size", s.crop_size},
                      {"sampling", s.crop_sampling},
                      {"levels", s.crop_levels},
                      {"columns", s.crop_columns},
                      {"canonical_scale", s.canonical_scale},
                      {"canonical_level", s.canonical_level}};
  sidecar["boxes"] = {{"weights", s.box_weights}, {"most", s.most_boxes}};
}

}  // namespace plumbline
