// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/move.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

constexpr std::size_t kIncumbents = 200;

struct Round {
  int count;                       ///< Hypotheses kept for the next round.
  double temperature;              ///< Of the log-likelihood when choosing them.
  double position_m, azimuth_rad;  ///< Steps from the chosen ones.
};

/// Hypotheses and their log-likelihoods.
struct Population {
  std::vector<PoseHypothesis> hypotheses;
  std::vector<double> judged;
  void Add(const Population& other) {
    hypotheses.insert(hypotheses.end(), other.hypotheses.begin(), other.hypotheses.end());
    judged.insert(judged.end(), other.judged.begin(), other.judged.end());
  }
};

class Mover {
 public:
  Mover(const MapFrame& map, const MapperOptions& options, RandomKey key)
      : map_(map), options_(options), key_(key) {}

  /// A neighbour; heavy-tailed, one step in eight is three times as far.
  PoseHypothesis Step(PoseHypothesis hypothesis, double position_m, double azimuth_rad) {
    Random random = Next();
    const double reach = random.Uniform() < 0.125 ? 3.0 : 1.0;
    const Eigen::Matrix3d& upright = map_.upright.upright_rotation();
    const bool on_floor = options_.floor_prior && map_.StandsOnFloor(hypothesis.label);
    const Eigen::Vector3d step(
        reach * position_m * random.Gaussian(), reach * position_m * random.Gaussian(),
        (on_floor ? std::min(position_m, options_.floor_std_m) : reach * position_m) *
            random.Gaussian());
    hypothesis.center_in_world += upright * step;
    hypothesis.azimuth_rad =
        WrapAngle(hypothesis.azimuth_rad + reach * azimuth_rad * random.Gaussian());
    return hypothesis;
  }

  /// Turned by a half turn, a quarter turn or any angle about a vertical axis somewhere inside the
  /// object.
  PoseHypothesis Turned(PoseHypothesis hypothesis) {
    Random random = Next();
    const Eigen::Vector3d size =
        map_.database->model(hypothesis.label).bounds.sizes().cast<double>();
    const Eigen::Vector3d pivot(random.Uniform(-0.5, 0.5) * size.x(),
                                random.Uniform(-0.5, 0.5) * size.y(), 0);
    const double pick = random.Uniform();
    const double turn = pick < 0.4   ? std::numbers::pi
                        : pick < 0.7 ? (pick < 0.55 ? 0.5 : -0.5) * std::numbers::pi
                                     : Next().Uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Matrix3d before = map_.upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
    const Eigen::Matrix3d after =
        map_.upright.WorldFromObjectRotation(hypothesis.azimuth_rad + turn);
    hypothesis.center_in_world += before * pivot - after * pivot;
    hypothesis.azimuth_rad = WrapAngle(hypothesis.azimuth_rad + turn);
    return hypothesis;
  }

  PoseHypothesis Relabelled(PoseHypothesis hypothesis) {
    Random random = Next();
    const auto same = map_.database->OfCategory(map_.database->model(hypothesis.label).category);
    const ModelId label = same[random.Index(static_cast<std::uint32_t>(same.size()))];
    if (map_.StandsOnFloor(label) && map_.StandsOnFloor(hypothesis.label)) {
      const double rise = map_.database->model(label).center().z() -
                          map_.database->model(hypothesis.label).center().z();
      hypothesis.center_in_world += rise * map_.upright.up_in_world();
    }
    hypothesis.label = label;
    return hypothesis;
  }

  /// Indices drawn in proportion to exp(log_likelihood / temperature), systematically.
  std::vector<std::size_t> Choose(const std::vector<double>& log_likelihood, double temperature,
                                  int count) {
    const double highest = *std::max_element(log_likelihood.begin(), log_likelihood.end());
    std::vector<double> sums;
    double sum = 0;
    for (const double value : log_likelihood)
      sums.push_back(sum += std::exp((value - highest) / temperature));
    const double start = Next().Uniform();
    std::vector<std::size_t> chosen;
    for (int i = 0; i < count; ++i) {
      const auto found = std::upper_bound(sums.begin(), sums.end(), (i + start) * sum / count);
      chosen.push_back(std::min(static_cast<std::size_t>(found - sums.begin()), sums.size() - 1));
    }
    return chosen;
  }

  Random Next() {
    ++key_.particle;
    return Random(key_);
  }

 private:
  const MapFrame& map_;
  const MapperOptions& options_;
  RandomKey key_;
};

}  // namespace

std::vector<double> JudgeHypotheses(const HypothesisScorer& scorer, const MapFrame& map,
                                    std::span<const JudgingView> views,
                                    std::span<const PoseHypothesis> hypotheses,
                                    const MapperOptions& options) {
  std::vector<double> sums(hypotheses.size(), 0.0);
  for (const JudgingView& judging : views) {
    const std::vector<Likelihood> likelihoods = Evaluate(
        scorer, judging.view, map, judging.detections, hypotheses, judging.normalizer, options);
    for (std::size_t i = 0; i < sums.size(); ++i) {
      sums[i] += options.alpha * likelihoods[i].phi_cnn + options.beta * likelihoods[i].phi_edge;
    }
  }
  if (options.floor_prior) {
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (!map.StandsOnFloor(hypotheses[i].label)) continue;
      const double height = map.BaseHeight(hypotheses[i]) / options.floor_std_m;
      sums[i] -= 0.5 * height * height;
    }
  }
  return sums;
}

std::vector<PoseHypothesis> ResampleMove(const HypothesisScorer& scorer, const MapFrame& map,
                                         std::span<const JudgingView> views, const MoveInput& input,
                                         int count, const MapperOptions& options, RandomKey key) {
  PLB_CHECK(!input.particles.empty() && !views.empty());
  Mover mover(map, options, key);
  const auto judge = [&](Population& population) {
    population.judged = JudgeHypotheses(scorer, map, views, population.hypotheses, options);
  };
  const auto run = [&](Population& population, const Round& round) {
    Population next, steps;
    for (const std::size_t index :
         mover.Choose(population.judged, round.temperature, round.count)) {
      next.hypotheses.push_back(population.hypotheses[index]);
      next.judged.push_back(population.judged[index]);
      steps.hypotheses.push_back(
          mover.Step(population.hypotheses[index], round.position_m, round.azimuth_rad));
    }
    judge(steps);
    next.Add(steps);
    population = std::move(next);
  };

  Population incumbents, challengers{input.newcomers, {}};
  const std::size_t kept = std::min(input.particles.size(), kIncumbents);
  const std::size_t stride = input.particles.size() / kept;
  for (std::size_t i = 0; i < kept; ++i) {
    const PoseHypothesis& particle = input.particles[i * stride];
    incumbents.hypotheses.push_back(particle);
    if (i % 4 == 3) incumbents.hypotheses.push_back(mover.Relabelled(particle));
    if (input.wide && i % 2 == 0)
      incumbents.hypotheses.push_back(mover.Step(particle, 0.08, 8 * kRadPerDeg));
    if (input.wide) challengers.hypotheses.push_back(mover.Turned(particle));
  }
  judge(incumbents);
  // Challengers come from far and are rough: they compete among themselves until they are as
  // refined as the incumbents.
  static constexpr Round kRefine[] = {{100, 3.0, 0.05, 6 * kRadPerDeg},
                                      {60, 2.0, 0.025, 3 * kRadPerDeg},
                                      {60, 1.5, 0.012, 1.5 * kRadPerDeg}};
  static constexpr Round kIncumbent = {120, 2.0, 0.02, 2.5 * kRadPerDeg};
  static constexpr Round kFinal = {150, 1.5, 0.01, 1.2 * kRadPerDeg};
  if (!challengers.hypotheses.empty()) {
    judge(challengers);
    for (const Round& round : kRefine) run(challengers, round);
  }
  run(incumbents, kIncumbent);
  incumbents.Add(challengers);
  run(incumbents, kFinal);

  std::vector<PoseHypothesis> result;
  std::vector<bool> taken(incumbents.hypotheses.size(), false);
  for (const std::size_t index : mover.Choose(incumbents.judged, 1.0, count)) {
    // Copies of one hypothesis spread a little, so that they go on as different particles.
    const PoseHypothesis& chosen = incumbents.hypotheses[index];
    result.push_back(taken[index] ? mover.Step(chosen, 0.004, 0.5 * kRadPerDeg) : chosen);
    taken[index] = true;
  }
  return result;
}

}  // namespace plumbline
