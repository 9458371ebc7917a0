// SPDX-License-Identifier: Apache-2.0
#include "engine/batch/batch_plan.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "engine/base/files.h"

namespace plumbline {
namespace {

using nlohmann::json;

json SequenceToJson(const PlannedSequence& sequence) {
  json entry = {{"name", sequence.name}};
  if (!sequence.synth.empty()) {
    entry["synth"] = sequence.synth;
    return entry;
  }
  entry["path"] = sequence.path.string();
  const auto add = [&](const char* key, const std::filesystem::path& path) {
    if (!path.empty()) entry[key] = path.string();
  };
  add("ground_truth", sequence.ground_truth);
  add("models", sequence.models);
  add("scene", sequence.scene);
  return entry;
}

}  // namespace

Result<BatchPlan> ReadBatchPlan(const std::filesystem::path& file) {
  const Result<json> given = ReadJson(file);
  if (!given.ok()) return given.error();
  std::error_code error;
  Result<BatchPlan> plan =
      BatchPlanFromJson(*given, std::filesystem::absolute(file, error).parent_path());
  if (!plan.ok())
    return Error{plan.error().code, "'" + file.string() + "': " + plan.error().message};
  if (plan->name.empty()) plan->name = file.stem().string();
  return plan;
}

json BatchPlanToJson(const BatchPlan& plan) {
  json result = {
      {"name", plan.name}, {"seeds", plan.seeds}, {"gate", plan.gate}, {"slurm", plan.slurm}};
  result["sequences"] = json::array();
  for (const PlannedSequence& sequence : plan.sequences)
    result["sequences"].push_back(SequenceToJson(sequence));
  result["recipes"] = json::array();
  for (const PlannedRecipe& recipe : plan.recipes) {
    json entry = {{"name", recipe.name}, {"arguments", recipe.words}};
    if (!recipe.program.empty()) entry["program"] = recipe.program.string();
    result["recipes"].push_back(std::move(entry));
  }
  for (const SweptOption& swept : plan.sweep) result["sweep"][swept.option] = swept.values;
  result["evaluate"] = {{"samples", plan.evaluation.samples},
                        {"single_frames", plan.evaluation.single_frames},
                        {"align", plan.evaluation.align},
                        {"ignore_categories", plan.evaluation.ignored_categories}};
  if (plan.timeout_s) result["timeout_s"] = *plan.timeout_s;
  return result;
}

std::vector<std::vector<double>> PointsOf(const BatchPlan& plan) {
  std::vector<std::vector<double>> points = {{}};
  for (const SweptOption& swept : plan.sweep) {
    std::vector<std::vector<double>> longer;
    for (const std::vector<double>& point : points) {
      for (const double value : swept.values) {
        longer.push_back(point);
        longer.back().push_back(value);
      }
    }
    points = std::move(longer);
  }
  return points;
}

std::string PointInWords(const std::vector<std::string>& options,
                         const std::vector<double>& point) {
  std::string words;
  for (std::size_t i = 0; i < point.size() && i < options.size(); ++i)
    words += fmt::format("{}{}={:g}", words.empty() ? "" : " ", options[i], point[i]);
  return words;
}

}  // namespace plumbline
