// SPDX-License-Identifier: Apache-2.0
// Where settled objects are seen again after the poses have drifted (docs/algorithms/vio.md,
// "Coming back").
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

#include "engine/base/random.h"
#include "engine/mapping/mapper_impl.h"
#include "engine/mapping/pose_error.h"
#include "engine/mapping/pose_sampler.h"

namespace plumbline {
namespace {

constexpr int kDraws = 600, kKept = 150;
constexpr std::size_t kMinViews = 3;  ///< By which it is located again ...
constexpr double kMinTelling = 0.3;   ///< ... each of which says so much (Judging::telling),
constexpr double kMinVisible = 0.3;   ///< and shows so much of its contour.
/// A filter believes in less drift than there is: draws reach so many times as far.
constexpr double kDriftFactor = 3;
/// What is not located to this is not located.
constexpr double kMaxSpread_m = 0.04, kMaxSpreadRad = 0.07;
/// What contours place differently from one side and from another: of each of both, beside the
/// posteriors' own spread.
constexpr double kContourStd_m = 0.008, kContourStdRad = 0.008;
constexpr double kMinModeWeight = 0.9;
constexpr double kAnyAzimuth = 100;  ///< Variance where every azimuth looks alike [rad^2].

double PositionStd(const Eigen::Matrix4d& covariance) {
  return std::sqrt(std::max(0.0, covariance.diagonal().head<3>().maxCoeff()));
}

/// Square root of a covariance that may not be quite positive.
Eigen::Matrix4d RootOf(const Eigen::Matrix4d& covariance) {
  const Eigen::LDLT<Eigen::Matrix4d> parts((covariance + covariance.transpose()) / 2);
  const Eigen::Vector4d roots = parts.vectorD().cwiseMax(0).cwiseSqrt();
  Eigen::Matrix4d root = parts.matrixL();
  root = root * roots.asDiagonal();
  return parts.transpositionsP().transpose() * root;
}

/// The difference to the nearest azimuth that looks like `other`.
double TurnFrom(double other_rad, double azimuth_rad, int symmetry_order) {
  const double period = 2 * std::numbers::pi / std::max(1, symmetry_order);
  return std::remainder(azimuth_rad - other_rad, period);
}

}  // namespace

void Mapper::Impl::FindLandmarks(const MapperInput& input, FrameReport& report) const {
  if (options().landmark_drift_m <= 0 || memory.Find(input.frame) == nullptr) return;
  for (const MapObject& object : objects) {
    if (auto sighting = SeenAgain(object, input)) report.landmarks.push_back(*std::move(sighting));
  }
}

std::optional<LandmarkSighting> Mapper::Impl::SeenAgain(const MapObject& object,
                                                        const MapperInput& input) const {
  if (object.state != ObjectState::kConfirmed || object.log_evidence < kSettledLogOdds ||
      !object.updated || object.visible_fraction < kMinVisible || object.hidden > 0.5 ||
      object.mean().weight < kMinModeWeight)
    return std::nullopt;
  const PoseHypothesis known = ToHypothesis(object.mean(), map);
  const UncertainView present{input.world_from_cam, input.pose_uncertainty};
  const Eigen::Matrix4d drift =
      InFour(DriftAt(known.center_in_world, present,
                     {object.world_from_reference_cam, object.reference_uncertainty}));
  if (PositionStd(drift) < options().landmark_drift_m) return std::nullopt;

  // Views that hang together with this one, whatever was before.
  MapObject now = object;
  now.world_from_reference_cam = input.world_from_cam;
  now.reference_uncertainty = input.pose_uncertainty;
  std::vector<JudgingView> views;
  double weight = 0;
  for (const KeyFrame& key : memory.frames()) {
    const Eigen::Matrix4d since = InFour(DriftAt(
        known.center_in_world, present, {key.input.world_from_cam, key.input.pose_uncertainty}));
    if (PositionStd(since) > 0.5 * options().landmark_drift_m) continue;
    Judging judging = Judge(now, key.input, key.maps);
    if (judging.visible_fraction < kMinVisible || judging.telling < kMinTelling) continue;
    judging.view.weight = judging.telling;
    weight += judging.telling;
    views.push_back(std::move(judging.view));
  }
  if (views.size() < kMinViews) return std::nullopt;
  const double scale = ViewScale(weight, object.sharpness, OptionsFor(object.mean().label));
  // Neither the floor nor what it knew says anything here: a drift in height would be hidden.
  const Target target = [&](std::span<const PoseHypothesis> hypotheses) {
    const std::vector<double> sums = SumOverViews(*setup.scorer, map, views, hypotheses, options());
    std::vector<Judgement> judged(sums.size());
    for (std::size_t i = 0; i < sums.size(); ++i) judged[i].log_target = scale * sums[i];
    return judged;
  };

  const RandomKey key = Key(setup.seed, input.frame, object.id, Draw::kLandmark);
  Random random(key);
  const Eigen::Matrix4d root = kDriftFactor * RootOf(drift + object.covariance);
  std::vector<PoseHypothesis> draws = {known};
  while (static_cast<int>(draws.size()) < kDraws) {
    Eigen::Vector4d normal;
    for (double& value : normal.reshaped()) value = random.Gaussian();
    const Eigen::Vector4d moved = root * normal;
    PoseHypothesis draw = known;
    draw.center_in_world += moved.head<3>();
    draw.azimuth_rad += moved[3];
    draws.push_back(draw);
  }
  RandomKey moves = key;
  moves.particle = kDraws;
  const Population found = PoseSampler(map, options(), target, moves).Temper(draws, kKept);

  const int order = setup.database->model(known.label).symmetry.order;
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  std::vector<Eigen::Vector4d> offsets;
  for (const PoseHypothesis& hypothesis : found.hypotheses) {
    Eigen::Vector4d offset;
    offset << hypothesis.center_in_world - known.center_in_world,
        order == 0 ? 0 : TurnFrom(known.azimuth_rad, hypothesis.azimuth_rad, order);
    mean += offset / static_cast<double>(found.size());
    offsets.push_back(offset);
  }
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  for (const Eigen::Vector4d& offset : offsets)
    covariance += (offset - mean) * (offset - mean).transpose() / static_cast<double>(found.size());
  if (PositionStd(covariance) > kMaxSpread_m || std::sqrt(covariance(3, 3)) > kMaxSpreadRad)
    return std::nullopt;

  LandmarkSighting sighting;
  sighting.object = object.id;
  sighting.reference_pose = object.reference_pose;
  sighting.present_pose = input.pose_id;
  sighting.center_in_world = known.center_in_world;
  sighting.center_in_world_now = known.center_in_world + mean.head<3>();
  sighting.azimuth_rad = known.azimuth_rad;
  sighting.azimuth_now_rad = known.azimuth_rad + mean[3];
  sighting.covariance = covariance + object.covariance;
  sighting.covariance.diagonal().head<3>().array() += 2 * kContourStd_m * kContourStd_m;
  sighting.covariance(3, 3) += 2 * kContourStdRad * kContourStdRad;
  if (order == 0) sighting.covariance(3, 3) = kAnyAzimuth;
  return sighting;
}

}  // namespace plumbline
