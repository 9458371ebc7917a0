// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/placement_success.h"

#include <cmath>
#include <limits>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/check.h"
#include "engine/geometry/assignment.h"

namespace plumbline {
namespace {

/// How far apart in the sense of Scan2CAD, infinite outside its limits.
double SuccessCost(const EstimatedObject& estimate, const Eigen::Isometry3d& truth_from_estimate,
                   const GroundTruthInstance& truth, const Symmetry& symmetry,
                   const UprightFrame& upright) {
  constexpr double kWrong = std::numeric_limits<double>::infinity();
  if (estimate.category != truth.category) return kWrong;
  const PoseError error = ComparePoses(truth_from_estimate * estimate.world_from_object,
                                       truth.world_from_object, symmetry, upright);
  const bool right = error.translation_m <= kSuccess_m && error.rotation_rad <= kSuccess_rad &&
                     std::abs(estimate.scale / truth.scale - 1) <= kSuccessScale;
  return right ? error.translation_m : kWrong;
}

nlohmann::json SuccessToJson(const SuccessCount& count) {
  return {{"right", count.right},
          {"truths", count.truths},
          {"share", count.truths > 0 ? nlohmann::json(count.share()) : nullptr}};
}

}  // namespace

PlacementSuccess MeasurePlacement(const MapEvaluation& evaluation, const GroundTruth& truth,
                                  const ModelDatabase& database) {
  std::vector<const EstimatedObject*> estimates;
  std::vector<const GroundTruthInstance*> truths;
  PlacementSuccess placement;
  for (const MatchedObject& object : evaluation.matched) {
    estimates.push_back(&object.estimate);
    truths.push_back(&object.truth);
    if (!object.add) continue;
    const double error_m = object.add->symmetric ? object.add->add_s_m : object.add->add_m;
    placement.add.right += error_m < kAddShare * object.add->diameter_m;
  }
  for (const SpuriousObject& object : evaluation.spurious) estimates.push_back(&object.estimate);
  for (const GroundTruthInstance& instance : evaluation.missed) truths.push_back(&instance);

  const UprightFrame upright(truth.gravity_in_world);
  Eigen::MatrixXd cost(estimates.size(), truths.size());
  for (Eigen::Index j = 0; j < cost.cols(); ++j) {
    const GroundTruthInstance& instance = *truths[static_cast<std::size_t>(j)];
    const std::optional<ModelId> model = database.Find(instance.model);
    PLB_CHECK(model.has_value()) << instance.model;
    for (Eigen::Index i = 0; i < cost.rows(); ++i) {
      cost(i, j) =
          SuccessCost(*estimates[static_cast<std::size_t>(i)], evaluation.truth_from_estimate,
                      instance, database.model(*model).symmetry, upright);
    }
    ++placement.by_category[instance.category].truths;
  }
  for (const std::optional<int>& pair : AssignOneToOne(cost)) {
    if (pair) ++placement.by_category[truths[static_cast<std::size_t>(*pair)]->category].right;
  }
  double shares = 0;
  for (const auto& [category, count] : placement.by_category) {
    placement.all.right += count.right;
    placement.all.truths += count.truths;
    shares += count.share();
  }
  placement.add.truths = placement.all.truths;
  if (!placement.by_category.empty())
    placement.category_mean = shares / static_cast<double>(placement.by_category.size());
  return placement;
}

nlohmann::json PlacementToJson(const PlacementSuccess& placement) {
  nlohmann::json categories = nlohmann::json::object();
  for (const auto& [category, count] : placement.by_category)
    categories[category] = SuccessToJson(count);
  nlohmann::json scan2cad = SuccessToJson(placement.all);
  scan2cad["category_mean"] =
      placement.category_mean ? nlohmann::json(*placement.category_mean) : nullptr;
  scan2cad["by_category"] = std::move(categories);
  return {{"scan2cad", std::move(scan2cad)}, {"add", SuccessToJson(placement.add)}};
}

}  // namespace plumbline
