// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/resampling.h"

#include <cmath>

#include "engine/geometry/angles.h"

namespace plumbline {
namespace {

constexpr int kParticles = 400;
constexpr std::size_t kChallengers = 160;
constexpr int kJumps = 2, kWalks = 4;
constexpr double kSamePose_m = 0.15, kSamePose_rad = 30 * kRadPerDeg;

Population Draw(const MapObject& object, const PoseSampler& sampler, RandomKey key) {
  Population population;
  for (const Particle& particle : SystematicResample(object.particles, kParticles, key))
    population.hypotheses.push_back(ToHypothesis(particle, object.world_from_reference_cam));
  population.judged = sampler.Judge(population.hypotheses);
  return population;
}

}  // namespace

void Resample(const HypothesisScorer& scorer, const MapFrame& map,
              std::span<const ObjectImage> images, const MapperOptions& options, RandomKey key,
              MapObject& object) {
  if (images.empty()) return;
  std::vector<JudgingView> views;
  for (const ObjectImage& image : images) views.push_back(image.judging);
  const JudgingView last = views.back();
  views.pop_back();
  PoseSampler sampler(map, options, Posterior(scorer, map, std::move(views), last, options), key);
  Population population = Draw(object, sampler, key);
  const std::vector<ProposalMode> modes =
      sampler.FindModes(population, sampler.Challengers(population.hypotheses, kChallengers));
  for (int i = 0; i < kJumps; ++i) sampler.Jump(population, modes);
  for (int i = 0; i < kWalks; ++i) sampler.Walk(population);
  object.particles.clear();
  for (const PoseHypothesis& hypothesis : population.hypotheses) {
    object.particles.push_back(ToParticle(hypothesis, object.world_from_reference_cam));
    object.particles.back().log_weight = -std::log(static_cast<float>(population.size()));
  }
  object.Summarize(map);
  object.effective_sample_size = static_cast<double>(population.size());
}

double BeliefInMean(const MapObject& object, const MapFrame& map) {
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  double sum = 0;
  for (const PoseMode& mode : object.modes) {
    const PoseHypothesis other = ToHypothesis(mode, map);
    const double turn =
        AzimuthDifference(map.database->model(mean.label), other.azimuth_rad, mean.azimuth_rad);
    if ((other.center_in_world - mean.center_in_world).norm() < kSamePose_m &&
        std::abs(turn) < kSamePose_rad)
      sum += mode.weight;
  }
  return sum;
}

}  // namespace plumbline
