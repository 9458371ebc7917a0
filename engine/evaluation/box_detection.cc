// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/box_detection.h"

#include <algorithm>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/evaluation/object_pairs.h"
#include "engine/evaluation/standing_box.h"

namespace plumbline {
namespace {

struct RankedBox {
  double probability = 0;
  StandingBox box;
};

/// What a category has.
struct CategoryBoxes {
  std::vector<RankedBox> candidates;  ///< By falling probability.
  std::vector<StandingBox> truths;
};

/// Each candidate in turn takes the true box that it overlaps most, if by enough and not taken.
/// Area under precision over recall, the precision made to fall (PASCAL VOC since 2010).
double AveragePrecision(const CategoryBoxes& boxes, double least_iou) {
  std::vector<bool> taken(boxes.truths.size(), false);
  std::vector<double> precision;
  std::vector<bool> right;
  int num_right = 0;
  for (const RankedBox& candidate : boxes.candidates) {
    std::size_t best = 0;
    double best_iou = -1;
    for (std::size_t j = 0; j < boxes.truths.size(); ++j) {
      const double iou = Iou(candidate.box, boxes.truths[j]);
      if (iou <= best_iou) continue;
      best_iou = iou;
      best = j;
    }
    right.push_back(best_iou >= least_iou && !taken[best]);
    if (right.back()) taken[best] = true;
    num_right += right.back();
    precision.push_back(static_cast<double>(num_right) / static_cast<double>(right.size()));
  }
  double area = 0, highest = 0;
  for (std::size_t i = right.size(); i-- > 0;) {
    highest = std::max(highest, precision[i]);
    if (right[i]) area += highest;
  }
  return area / static_cast<double>(boxes.truths.size());
}

BoxPrecision PrecisionAt(const std::map<std::string, CategoryBoxes>& categories, double least_iou) {
  BoxPrecision result;
  double sum = 0;
  for (const auto& [category, boxes] : categories) {
    if (boxes.truths.empty()) continue;
    sum += result.by_category[category] = AveragePrecision(boxes, least_iou);
  }
  if (!result.by_category.empty())
    result.mean = sum / static_cast<double>(result.by_category.size());
  return result;
}

nlohmann::json PrecisionToJson(const BoxPrecision& precision) {
  return {{"mean", precision.mean ? nlohmann::json(*precision.mean) : nullptr},
          {"by_category", precision.by_category}};
}

}  // namespace

Result<BoxDetection> MeasureDetection(std::span<const EstimatedObject> candidates,
                                      const GroundTruth& truth, const ModelDatabase& database,
                                      const MapEvaluation& evaluation,
                                      const EvaluationOptions& options) {
  const Result<CountedObjects> objects =
      CollectObjects(candidates, truth, database, options.ignored_categories);
  if (!objects) return objects.error();
  std::map<std::string, CategoryBoxes> categories;
  for (std::size_t j = 0; j < objects->truths.size(); ++j) {
    const GroundTruthInstance& instance = objects->truths[j];
    categories[instance.category].truths.push_back(BoxOf(
        *objects->truth_models[j], instance.world_from_object, instance.scale, objects->upright));
  }
  for (std::size_t i = 0; i < objects->estimates.size(); ++i) {
    const EstimatedObject& estimate = objects->estimates[i];
    categories[estimate.category].candidates.push_back(
        {estimate.probability, BoxOf(*objects->estimate_models[i],
                                     evaluation.truth_from_estimate * estimate.world_from_object,
                                     estimate.scale, objects->upright)});
  }
  for (auto& [category, boxes] : categories) {
    std::stable_sort(boxes.candidates.begin(), boxes.candidates.end(),
                     [](const auto& a, const auto& b) { return a.probability > b.probability; });
  }
  return BoxDetection{PrecisionAt(categories, 0.25), PrecisionAt(categories, 0.5),
                      static_cast<int>(objects->estimates.size())};
}

nlohmann::json DetectionToJson(const BoxDetection& detection) {
  return {{"iou_25", PrecisionToJson(detection.at_25)},
          {"iou_50", PrecisionToJson(detection.at_50)},
          {"candidates", detection.candidates}};
}

}  // namespace plumbline
