// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/likelihood.h"

#include <algorithm>
#include <cmath>

namespace plumbline {
namespace {

// The same object shows a quarter more or less contour from twin poses; that must not decide
// between them.
constexpr float kTypicalShare = 0.7f;
constexpr float kWholeShare = 0.2f;

}  // namespace

double DetectorWeight(std::string_view category, const Eigen::AlignedBox3f& bounds,
                      const MapperOptions& options) {
  return LengthScale(category, bounds, options.room_thing_m) > 1 ? options.large_alpha
                                                                 : options.alpha;
}

float EdgeNormalizer(std::span<const HypothesisScore> scores) {
  if (scores.empty()) return 0;
  std::vector<float> visible, total;
  for (const HypothesisScore& score : scores) {
    visible.push_back(score.visible_m);
    total.push_back(score.total_m);
  }
  const auto median = [](std::vector<float>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  return std::max(kTypicalShare * median(visible), kWholeShare * median(total));
}

std::vector<float> EdgeTerms(const HypothesisScorer& scorer, const ScoringView& view,
                             const UprightFrame& upright,
                             std::span<const PoseHypothesis> hypotheses,
                             std::span<const HypothesisScore> scores, float normalizer,
                             double sharpness) {
  const auto term = [&](const HypothesisScore& score) {
    return normalizer > 0 ? score.agreement_m / std::max(normalizer, score.visible_m) : 0.0f;
  };
  std::vector<float> terms;
  for (const HypothesisScore& score : scores) terms.push_back(term(score));
  if (view.shifts.empty() || sharpness <= 0) return terms;
  double here = 0;
  std::vector<ImageShift> elsewhere;
  for (const ImageShift& shift : view.shifts) {
    if (shift.x_px == 0 && shift.y_px == 0)
      here += shift.weight;
    else
      elsewhere.push_back(shift);
  }
  const std::vector<HypothesisScore> there =
      scorer.ScoreShifts(view, upright, hypotheses, elsewhere);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    double sum = here * std::exp(sharpness * terms[i]);
    for (std::size_t k = 0; k < elsewhere.size(); ++k)
      sum += elsewhere[k].weight * std::exp(sharpness * term(there[k * terms.size() + i]));
    terms[i] = static_cast<float>(std::log(sum) / sharpness);
  }
  return terms;
}

std::vector<Likelihood> Evaluate(const HypothesisScorer& scorer, const ScoringView& view,
                                 const MapFrame& map, const FrameDetections* detections,
                                 std::span<const PoseHypothesis> hypotheses,
                                 std::optional<float> normalizer, const MapperOptions& options) {
  std::vector<HypothesisScore> scores(hypotheses.size());
  scorer.Score(view, map.upright, hypotheses, scores);
  const float length = normalizer.value_or(EdgeNormalizer(scores));
  const std::vector<float> edges =
      EdgeTerms(scorer, view, map.upright, hypotheses, scores, length, options.beta);
  std::vector<Likelihood> result(hypotheses.size());
  std::vector<Box2> boxes;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    Likelihood& likelihood = result[i];
    likelihood.phi_edge = edges[i];
    likelihood.visible_fraction =
        scores[i].total_m > 0 ? scores[i].visible_m / scores[i].total_m : 0.0f;
    likelihood.whole_box = scores[i].whole_box;
    likelihood.visible_box = scores[i].visible_box;
    boxes.push_back(likelihood.whole_box);
    if (options.scored_box == ScoredBox::kBest) boxes.push_back(likelihood.visible_box);
  }
  if (detections == nullptr || hypotheses.empty()) return result;
  // Hypotheses of one object share a category unless labels jump over all: then each category is
  // scored by itself.
  const std::size_t stride = options.scored_box == ScoredBox::kBest ? 2 : 1;
  std::vector<float> box_scores(boxes.size());
  std::vector<std::string> categories;
  for (const PoseHypothesis& hypothesis : hypotheses) {
    const std::string& category = map.database->model(hypothesis.label).category;
    if (std::find(categories.begin(), categories.end(), category) == categories.end())
      categories.push_back(category);
  }
  for (const std::string& category : categories) {
    detections->ScoreBoxes(category, boxes, box_scores);
    for (std::size_t i = 0; i < hypotheses.size(); ++i) {
      if (map.database->model(hypotheses[i].label).category != category) continue;
      float best = box_scores[i * stride];
      if (stride == 2) best = std::max(best, box_scores[i * stride + 1]);
      result[i].phi_cnn = best;
    }
  }
  return result;
}

}  // namespace plumbline
