// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_figures.h"

#include <array>
#include <cmath>

#include <nlohmann/json.hpp>

#include "engine/dataset/json_fields.h"

namespace plumbline {
namespace {

using nlohmann::json;
using Value = std::optional<double>;

/// The number at a place of the evaluation, times `scale`.
Value NumberAt(const json& evaluation, const char* place, double scale) {
  const json::json_pointer pointer(place);
  if (!evaluation.contains(pointer) || !evaluation[pointer].is_number()) return std::nullopt;
  const double value = evaluation[pointer].get<double>();
  return std::isfinite(value) ? Value(scale * value) : std::nullopt;
}

double CountAt(const json& evaluation, const char* place) {
  return NumberAt(evaluation, place, 1).value_or(0);
}

Value ShareOf(double part, double all) { return all > 0 ? Value(100 * part / all) : std::nullopt; }

Value Found(const json& e) {
  const double matched = CountAt(e, "/matched");
  return ShareOf(matched, matched + CountAt(e, "/missed"));
}

Value FoundAndRight(const json& e) {
  const double twice = 2 * CountAt(e, "/matched");
  return ShareOf(twice, twice + CountAt(e, "/missed") + CountAt(e, "/spurious"));
}

Value RightModel(const json& e) {
  const json objects = e.value("objects", json::array());
  double right = 0, all = 0;
  for (const json& object : objects) {
    ++all;
    if (object.is_object() && object.value("model_correct", json(false)) == json(true)) ++right;
  }
  return ShareOf(right, all);
}

template <const char* kPlace, int kScale>
Value At(const json& e) {
  return NumberAt(e, kPlace, kScale);
}

constexpr char kSpurious[] = "/spurious", kTranslation[] = "/all/mean_translation_m",
               kRotation[] = "/all/mean_rotation_deg", kSurface[] = "/surface/mean_m",
               kCompleteness[] = "/completeness/mean_m", kPlaced[] = "/placement/scan2cad/share",
               kAdd[] = "/placement/add/share", kAp25[] = "/detection/iou_25/mean",
               kAp50[] = "/detection/iou_50/mean", kBop[] = "/single_frames/ar",
               kIn95[] = "/belief/along_the_run/truth_in_95_percent";

Value NotFailed(const json&) { return 0.0; }

/// How a figure is had from an evaluation, and what it is of a run that failed.
struct FigureSource {
  Value (*of)(const json& evaluation);
  Value of_failure;
};

constexpr int kFigures = 15;

const std::array<BatchFigure, kFigures>& Figures() {
  static const std::array<BatchFigure, kFigures> figures = {{
      {"failed", "%", "runs that crashed, hung or could not be judged", -1},
      {"found", "%", "true instances that are in the map", 1},
      {"spurious", "", "objects of the map that are no true instance", -1},
      {"f1", "%", "found and not spurious: twice matched over twice matched, missed, spurious", 1},
      {"right_model", "%", "found instances that have the right model", 1},
      {"translation", "cm", "mean distance of found instances from their true place", -1},
      {"rotation", "deg", "mean angle between found instances and the truth", -1},
      {"surface", "cm", "mean distance from the surface of the map to the true surface", -1},
      {"completeness", "cm", "mean distance from the true surfaces to those of the map", -1},
      {"placed", "%", "true instances within 20 cm, 20 deg and 20 % (Scan2CAD)", 1},
      {"add", "%", "true instances with ADD(-S) below a tenth of the diameter", 1},
      {"ap_25", "%", "average precision of boxes in space at an overlap of 0.25", 1},
      {"ap_50", "%", "the same at 0.5", 1},
      {"bop_ar", "%", "average recall in single images, as the BOP benchmark has it", 1},
      {"in_95", "%", "true poses in the 95 % region of the belief; 95 if that is honest", 0},
  }};
  return figures;
}

/// As Figures().
const std::array<FigureSource, kFigures>& Sources() {
  static const std::array<FigureSource, kFigures> sources = {{
      {NotFailed, 100.0},
      {Found, 0.0},
      {At<kSpurious, 1>, std::nullopt},
      {FoundAndRight, 0.0},
      {RightModel, std::nullopt},
      {At<kTranslation, 100>, std::nullopt},
      {At<kRotation, 1>, std::nullopt},
      {At<kSurface, 100>, std::nullopt},
      {At<kCompleteness, 100>, std::nullopt},
      {At<kPlaced, 100>, 0.0},
      {At<kAdd, 100>, 0.0},
      {At<kAp25, 100>, 0.0},
      {At<kAp50, 100>, 0.0},
      {At<kBop, 100>, 0.0},
      {At<kIn95, 100>, std::nullopt},
  }};
  return sources;
}

}  // namespace

std::span<const BatchFigure> BatchFigures() { return Figures(); }

std::vector<std::optional<double>> FiguresOf(const json& evaluation) {
  std::vector<Value> figures;
  for (const FigureSource& source : Sources()) figures.push_back(source.of(evaluation));
  return figures;
}

std::vector<std::optional<double>> FiguresOfFailure() {
  std::vector<Value> figures;
  for (const FigureSource& source : Sources()) figures.push_back(source.of_failure);
  return figures;
}

std::vector<BatchMiss> MissesOf(const json& evaluation) {
  std::vector<BatchMiss> misses;
  if (!evaluation.contains("missed_instances")) return misses;
  for (const json& missed : evaluation["missed_instances"]) {
    if (!missed.is_object()) continue;
    const json why = missed.value("why", json::object());
    misses.push_back({TextFromJson(missed, "ground_truth").value_or(""),
                      TextFromJson(missed, "model").value_or(""),
                      TextFromJson(why, "cause").value_or(""),
                      TextFromJson(why, "text").value_or("")});
  }
  return misses;
}

}  // namespace plumbline
