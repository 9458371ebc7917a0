// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/existence.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

/// A camera that walks fast gives a look an image, and a single image may mislead.
constexpr double kConfirmingLooks = 1.5;
/// In which a belief below 80 % would have begun anew (kInDoubt of mapper_belief.cc).
constexpr double kHeldLooks = 2;
/// Of the contour, for a belief that has held: a quarter hardly tells front from back.
constexpr double kHeldVisible = 0.3;
constexpr int kPlacesAround = 24;
/// As sharp as this a marginal over shifts is within 0.02 of the best: where a view is off is free
/// here, for the object as for the places around it. A likelihood would charge the object alone.
constexpr double kBestShift = 100;
constexpr double kGoldenAngle_rad = 2.39996322972865332;
constexpr double kNearestPlace = 0.6, kFarthestPlace = 1.5;  ///< In sizes of the object.
constexpr double kLeastSize_m = 0.3;
constexpr int kLeastPlaces = 6;
constexpr double kMostLogOdds = 15;
constexpr double kTellingBoxes = 2;  ///< More boxes, or fewer, tell little more [nats].

}  // namespace

double SightingLogRatio(const Sighting& sighting, const MapperOptions& options) {
  const double surplus = std::clamp(static_cast<double>(sighting.edge_surplus),
                                    -options.most_edge_surplus, options.most_edge_surplus);
  const double edges = options.evidence_per_edge * (surplus - options.expected_edge);
  // Few visible edges say little either way.
  return sighting.telling * std::min(1.0, sighting.edge_fraction / 0.3) * edges +
         BoxLogRatio(sighting, options);
}

double BoxLogRatio(const Sighting& sighting, const MapperOptions& options) {
  // The detector finds what is large enough, shows enough of itself and lies inside the image.
  const double found = options.detection_rate *
                       std::min(1.0, sighting.visible_px / options.detectable_px) *
                       std::min(1.0, sighting.visible_fraction / 0.5) * sighting.inside_fraction;
  const double quality = sighting.box_score * sighting.box_iou;
  return sighting.box_score > 0
             ? std::min(options.most_box_evidence,
                        std::log(1 - found + found * quality / options.false_box_quality))
             : std::log(1 - found);
}

double TentativeLogOdds(const TentativeEvidence& evidence, const MapperOptions& options) {
  // Without a memory of views frames are all there is.
  if (options.key_frames == 0) return evidence.passing;
  const auto limited = [](double sum) { return std::clamp(sum, -5.0, kMostLogOdds); };
  const double passing = options.passing_share * limited(evidence.passing);
  if (evidence.shown) {
    return options.shown_odds + passing +
           options.box_share * kTellingBoxes * std::tanh(evidence.boxes / kTellingBoxes);
  }
  return options.tentative_odds + passing + options.remembered_share * limited(evidence.remembered);
}

std::optional<double> BeliefToConfirm(double shown, double visible_fraction, bool rival,
                                      const MapperOptions& options) {
  if (shown < kConfirmingLooks) return std::nullopt;
  const bool held = shown >= kHeldLooks && visible_fraction >= kHeldVisible && !rival;
  return held ? options.confirm_held_weight : options.confirm_mode_weight;
}

void Existence::Update(const Sighting& sighting, double dt_s, const MapperOptions& options) {
  const double ratio = std::exp(sighting.novelty * SightingLogRatio(sighting, options));
  const double ends = 1 - std::exp(-dt_s / options.hidden_s);
  const double begins = options.hidden_rate * sighting.novelty;
  const double before = hidden * (1 - ends) + (1 - hidden) * begins;
  const double likelihood = before + (1 - before) * ratio;
  hidden = before / likelihood;
  log_odds = std::clamp(log_odds + std::log(likelihood), -kMostLogOdds, kMostLogOdds);
}

void Existence::UpdateInView(const Sighting& sighting, const MapperOptions& options) {
  hidden = 0;
  log_odds = std::clamp(log_odds + sighting.novelty * SightingLogRatio(sighting, options),
                        -kMostLogOdds, kMostLogOdds);
}

float EdgeSurplus(const HypothesisScorer& scorer, const ScoringView& view, const MapFrame& map,
                  const PoseHypothesis& pose) {
  const Eigen::Vector3d size =
      pose.scale() * map.database->model(pose.label).bounds.sizes().cast<double>();
  const double reach = std::max(kLeastSize_m, std::max(size.x(), size.y()));
  std::vector<PoseHypothesis> places = {pose};
  for (int k = 0; k < kPlacesAround; ++k) {
    PoseHypothesis place = pose;
    const double far =
        reach * (kNearestPlace + (kFarthestPlace - kNearestPlace) * k / (kPlacesAround - 1));
    place.center_in_world +=
        map.upright.upright_rotation() * Eigen::Vector3d(far * std::cos(kGoldenAngle_rad * k),
                                                         far * std::sin(kGoldenAngle_rad * k), 0);
    // Turned too: otherwise parallel edges of the same object, one slat further, would count.
    place.azimuth_rad = WrapAngle(pose.azimuth_rad + kGoldenAngle_rad * std::numbers::phi * k);
    places.push_back(place);
  }
  std::vector<HypothesisScore> scores(places.size());
  scorer.Score(view, map.upright, places, scores);
  const float length = EdgeNormalizer({scores.data(), 1});
  if (length <= 0) return 0;
  const std::vector<float> terms =
      EdgeTerms(scorer, view, map.upright, places, scores, length, kBestShift);
  double sum = 0;
  int count = 0;
  for (std::size_t k = 1; k < scores.size(); ++k) {
    if (scores[k].visible_m < 0.5f * scores[0].visible_m) continue;
    sum += terms[k];
    ++count;
  }
  return count < kLeastPlaces ? terms[0] : static_cast<float>(terms[0] - sum / count);
}

}  // namespace plumbline
