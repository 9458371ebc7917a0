// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/judging.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace plumbline {
namespace {

constexpr double kTakenPenalty = 12;  ///< [nats]
/// What is thinner takes this much to each side: another behind a screen is the same screen.
constexpr double kThin_m = 0.3;
/// How gradually the plane of a back begins to count: backs stand a little off their walls, and
/// poses are not exact [m].
constexpr double kBehind_m = 0.1;
constexpr double kAboveTop_m = 0.03;  ///< Where it is looked whether something reaches into a top.
constexpr double kDepthInTop_m = 0.02;  ///< Deviation: where a top ends is known that well.

Eigen::Vector3d CameraOf(const JudgingView& judging) {
  return judging.view.cam_from_world.inverse().translation();
}

double WeightOfDetector(const JudgingView& view, const MapFrame& map,
                        const PoseHypothesis& hypothesis, const MapperOptions& options) {
  if (view.detector_weight) return *view.detector_weight;
  const CadModel& model = map.database->model(hypothesis.label);
  return DetectorWeight(model.category, model.bounds, options);
}

}  // namespace

double IndependentViews(double weight, double correlation) {
  return weight / (1 + correlation * std::max(0.0, weight - 1));
}

double ViewScale(double weight, double sharpness, const MapperOptions& options) {
  return weight > 0 ? IndependentViews(sharpness * weight, options.view_correlation) / weight : 0;
}

std::vector<double> SumOverViews(const HypothesisScorer& scorer, const MapFrame& map,
                                 std::span<const JudgingView> views,
                                 std::span<const PoseHypothesis> hypotheses,
                                 const MapperOptions& options) {
  std::vector<double> sums(hypotheses.size(), 0.0);
  for (const JudgingView& judging : views) {
    const std::vector<Likelihood> likelihoods = Evaluate(
        scorer, judging.view, map, judging.detections, hypotheses, judging.normalizer, options);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      const double detector = WeightOfDetector(judging, map, hypotheses[i], options);
      sums[i] += judging.weight *
                 (detector * likelihoods[i].phi_cnn + options.beta * likelihoods[i].phi_edge);
    }
  }
  return sums;
}

namespace {

/// What need not stand on the floor is not below it either: flat above, normal from two deviations
/// below on.
double LogAboveFloor(const MapFrame& map, const PoseHypothesis& hypothesis,
                     const MapperOptions& options) {
  constexpr double kLeeway = 2;
  if (!map.floor_in_world) return 0;
  const std::vector<MapFrame::Standing> standings = map.StandingsAt(hypothesis.center_in_world);
  const MapFrame::Standing lowest =
      *std::min_element(standings.begin(), standings.end(),
                        [](const auto& a, const auto& b) { return a.height_m < b.height_m; });
  const double std_m = std::hypot(map.BaseStd(options), lowest.std_m);
  const double below = (lowest.height_m - map.BaseHeight(hypothesis)) / std_m - kLeeway;
  return below > 0 ? -0.5 * below * below : 0;
}

}  // namespace

double LogHeightPrior(const MapFrame& map, const PoseHypothesis& hypothesis,
                      const MapperOptions& options) {
  if (!options.floor_prior) return 0;
  if (map.database->model(hypothesis.label).support != Support::kFloor)
    return (map.supports.empty() ? 0
                                 : LogSupportPrior(map.supports, map.StandingThingOf(hypothesis))) +
           LogAboveFloor(map, hypothesis, options);
  if (!map.floor_in_world) return 0;
  // Relative to the density on the floor where there is no other level.
  const double base = map.BaseHeight(hypothesis), base_std = map.BaseStd(options);
  const std::vector<MapFrame::Standing> standings = map.StandingsAt(hypothesis.center_in_world);
  std::vector<double> terms;
  for (const MapFrame::Standing& standing : standings) {
    const double std_m = std::hypot(base_std, standing.std_m);
    const double off = (base - standing.height_m) / std_m;
    terms.push_back(-0.5 * off * off + std::log(base_std / std_m));
  }
  const double highest = *std::max_element(terms.begin(), terms.end());
  double sum = 0;
  for (const double term : terms) sum += std::exp(term - highest);
  return highest + std::log(sum / static_cast<double>(terms.size()));
}

double LogScalePrior(const PoseHypothesis& hypothesis, const MapperOptions& options) {
  if (options.scale_std <= 0) return 0;
  const double share = hypothesis.log_scale / options.scale_std;
  return -0.5 * share * share;
}

double LogBackPrior(const MapFrame& map, std::span<const Eigen::Vector3d> cameras_in_world,
                    const PoseHypothesis& hypothesis, const MapperOptions& options) {
  const CadModel& model = map.database->model(hypothesis.label);
  if (!model.back || options.seen_from_behind >= 1) return 0;
  const Eigen::Vector3d front_in_world =
      map.upright.WorldFromObjectRotation(hypothesis.azimuth_rad).col(0);
  const double back_m = hypothesis.scale() * (model.bounds.min().x() - model.center().x());
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& camera : cameras_in_world) {
    const double ahead_m = front_in_world.dot(camera - hypothesis.center_in_world) - back_m;
    least = std::min(least, ahead_m);
  }
  const double in_front = 1 / (1 + std::exp(-least / kBehind_m));
  return std::log(options.seen_from_behind + (1 - options.seen_from_behind) * in_front);
}

bool TakenPlace::Holds(const Eigen::Vector3d& center_in_world) const {
  const Eigen::Vector3d share = (center_from_world * center_in_world).cwiseQuotient(half_sizes_m);
  return share.head<2>().norm() < 1 && std::abs(share.z()) < 1;
}

TakenPlace PlaceOf(const CadModel& model, const Eigen::Isometry3d& world_from_object,
                   double scale) {
  TakenPlace place;
  place.center_from_world =
      Eigen::Translation3d(-scale * model.center()) * world_from_object.inverse();
  place.half_sizes_m = 0.5 * scale * model.bounds.sizes().cast<double>();
  for (double& half : place.half_sizes_m.head<2>())
    if (half < 0.5 * kThin_m) half = kThin_m;
  return place;
}

Target Outside(std::vector<TakenPlace> taken, Target target) {
  if (taken.empty()) return target;
  return [taken = std::move(taken),
          target = std::move(target)](std::span<const PoseHypothesis> hypotheses) {
    std::vector<Judgement> judged = target(hypotheses);
    for (std::size_t i = 0; i < judged.size(); ++i) {
      const bool inside = std::any_of(taken.begin(), taken.end(), [&](const TakenPlace& place) {
        return place.Holds(hypotheses[i].center_in_world);
      });
      if (inside) judged[i].log_target -= kTakenPenalty;
    }
    return judged;
  };
}

double DepthInTop(const SupportSurface& top, const std::vector<CrossSections>& sections,
                  const MapFrame& map, const PoseHypothesis& hypothesis) {
  const CadModel& model = map.database->model(hypothesis.label);
  if (model.support != Support::kFloor) return 0;
  const Eigen::Vector2d sides = hypothesis.scale() * model.bounds.sizes().head<2>().cast<double>();
  if (sides.prod() > top.side_a.norm() * top.side_b.norm()) return 0;
  const Eigen::Vector2d middle = top.corner + 0.5 * (top.side_a + top.side_b);
  const Eigen::Vector3d base = map.BaseInUpright(hypothesis);
  if ((base.head<2>() - middle).norm() >
      0.5 * sides.norm() + 0.5 * std::max(top.side_a.norm(), top.side_b.norm()))
    return 0;
  const std::span<const Eigen::Vector2f> points =
      sections[static_cast<std::size_t>(hypothesis.label.value)].At(
          (top.height_m + kAboveTop_m - base.z()) / hypothesis.scale());
  if (points.empty()) return 0;
  const Eigen::Matrix2d turn = (map.upright.upright_rotation().transpose() *
                                map.upright.WorldFromObjectRotation(hypothesis.azimuth_rad))
                                   .topLeftCorner<2, 2>();
  // From the object's axes to those in which the ellipse is the unit circle.
  Eigen::Matrix2d circle_from_upright;
  circle_from_upright << 2 * top.side_a.transpose() / top.side_a.squaredNorm(),
      2 * top.side_b.transpose() / top.side_b.squaredNorm();
  const Eigen::Matrix2d circle_from_object = hypothesis.scale() * circle_from_upright * turn;
  const Eigen::Vector2d offset = circle_from_upright * (base.head<2>() - middle) -
                                 circle_from_object * model.center().head<2>().cast<double>();
  double sum = 0;
  for (const Eigen::Vector2f& point : points)
    sum += std::max(0.0, 1 - (circle_from_object * point.cast<double>() + offset).norm());
  return 0.5 * std::min(top.side_a.norm(), top.side_b.norm()) * sum /
         static_cast<double>(points.size());
}

Target ClearOf(std::vector<SupportSurface> tops, const std::vector<CrossSections>& sections,
               const MapFrame& map, Target target) {
  if (tops.empty()) return target;
  return [tops = std::move(tops), &sections, &map,
          target = std::move(target)](std::span<const PoseHypothesis> hypotheses) {
    std::vector<Judgement> judged = target(hypotheses);
    for (std::size_t i = 0; i < judged.size(); ++i) {
      for (const SupportSurface& top : tops) {
        const double off = DepthInTop(top, sections, map, hypotheses[i]) / kDepthInTop_m;
        if (off > 0)
          judged[i].log_target +=
              std::log(kNoSurface + (1 - kNoSurface) * std::exp(-0.5 * off * off));
      }
    }
    return judged;
  };
}

double LogCrops(const CropBelief& crops, ModelId label, double azimuth_rad,
                const MapperOptions& options) {
  return options.crop_sharpness * ViewScale(crops.views(), 1, options) *
         crops.Likeness(label, azimuth_rad);
}

Target WithCrops(CropBelief crops, const MapperOptions& options, Target target) {
  if (crops.views() == 0) return target;
  return [crops = std::move(crops), &options,
          target = std::move(target)](std::span<const PoseHypothesis> hypotheses) {
    std::vector<Judgement> judged = target(hypotheses);
    for (std::size_t i = 0; i < judged.size(); ++i)
      judged[i].log_target +=
          LogCrops(crops, hypotheses[i].label, hypotheses[i].azimuth_rad, options);
    return judged;
  };
}

Target Posterior(const HypothesisScorer& scorer, const MapFrame& map,
                 std::vector<JudgingView> remembered, const JudgingView& present,
                 const MapperOptions& options, double sharpness) {
  double weight = present.weight;
  for (const JudgingView& view : remembered) weight += view.weight;
  const double scale = ViewScale(weight, sharpness, options);
  std::vector<Eigen::Vector3d> cameras = {CameraOf(present)};
  for (const JudgingView& view : remembered) cameras.push_back(CameraOf(view));
  return [&scorer, &map, &options, remembered = std::move(remembered), present,
          cameras = std::move(cameras), scale](std::span<const PoseHypothesis> hypotheses) {
    const std::vector<double> memory = SumOverViews(scorer, map, remembered, hypotheses, options);
    const std::vector<Likelihood> now = Evaluate(scorer, present.view, map, present.detections,
                                                 hypotheses, present.normalizer, options);
    std::vector<Judgement> judged(hypotheses.size());
    for (std::size_t i = 0; i < judged.size(); ++i) {
      judged[i].memory = static_cast<float>(memory[i]);
      judged[i].phi_cnn = now[i].phi_cnn;
      judged[i].phi_edge = now[i].phi_edge;
      const double detector = WeightOfDetector(present, map, hypotheses[i], options);
      judged[i].log_target =
          scale * (memory[i] +
                   present.weight * (detector * now[i].phi_cnn + options.beta * now[i].phi_edge)) +
          LogHeightPrior(map, hypotheses[i], options) + LogScalePrior(hypotheses[i], options) +
          LogBackPrior(map, cameras, hypotheses[i], options);
    }
    return judged;
  };
}

}  // namespace plumbline
