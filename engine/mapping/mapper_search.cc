// SPDX-License-Identifier: Apache-2.0
// The search for other poses and shapes of one object.
#include <algorithm>

#include "engine/mapping/mapper_impl.h"

namespace plumbline {
namespace {

/// The time between searches is the time in view over this, between the options' limits.
constexpr double kSearchRelaxation = 8.0;
constexpr std::size_t kChallengerCount = 160;  ///< Besides newcomers.
constexpr int kNewcomerCount = 100;
constexpr double kManyJumped =
    0.3;  ///< Share of accepted jumps that makes a second round worth it.

}  // namespace

void Mapper::Impl::GiveLeeway(MapObject& object, const Population& population,
                              const std::vector<ProposalMode>& modes,
                              const std::vector<JudgingView>& views, PoseSampler& sampler) {
  std::vector<ShapeLeeway> masses;
  if (object.sharpness > 1 && setup.database->OfCategory(object.category).size() > 1) {
    for (const ProposalMode& shape : sampler.ShapesOf(modes, population, object.sharpness)) {
      const ModelId label = shape.mean.label;
      masses.push_back({label, shape.weight - LogLeeway(object.leeway, label)});
    }
  }
  const double weight = object.remembered() + object.present_weight;
  const MapperOptions& of_shape = OptionsFor(object.mean().label);
  const double as_of_twins =
      ViewScale(weight, 1, of_shape) / ViewScale(weight, object.sharpness, of_shape);
  // Where no shape fits, what one fits better than another is no more than how badly both do:
  // overdispersion divides a likelihood (Burnham and Anderson, Model Selection, 2002).
  const ProposalMode& best = *std::ranges::max_element(modes, {}, &ProposalMode::weight);
  const double misfit = masses.size() < 2 ? 1
                                          : OutlineMisfit(*setup.scorer, map, views, best.mean,
                                                          of_shape, object.sharpness);
  std::vector<ShapeLeeway> leeway =
      LeewayOf(masses, std::min(as_of_twins, 1 / std::max(1.0, misfit)));
  if (leeway.empty() && object.leeway.empty()) return;
  for (Particle& particle : object.particles) {
    const ModelId label{particle.label};
    particle.log_weight +=
        static_cast<float>(LogLeeway(leeway, label) - LogLeeway(object.leeway, label));
  }
  NormalizeLogWeights(object.particles);
  object.leeway = std::move(leeway);
}

void Mapper::Impl::Search(MapObject& object, const MapperInput& input,
                          const OcclusionMaps& occluders) {
  if (options().key_frames == 0 || !object.updated) return;
  const bool tentative = object.state == ObjectState::kTentative;
  // What has been seen for long has been searched for often: the search relaxes with age.
  const double period =
      tentative ? options().tentative_search_s
                : std::clamp(object.seen_s / kSearchRelaxation, options().tentative_search_s,
                             options().confirmed_search_s);
  if (object.joined.empty() && object.seen_s - object.last_search_s < period - 1e-6) return;
  object.last_search_s = object.seen_s;
  const std::vector<double> last = LogLikelihoods(object);
  if (tentative) {
    // It may be elsewhere than it was thought to be: other frames may show it.
    object.views.clear();
    for (const KeyFrame* key : ChooseViews(object))
      object.views.push_back({key->input.frame, Judge(object, key->input, key->maps).telling});
    object.present_weight = 1;
    for (const ObjectView& seen : object.views) {
      object.present_weight = std::min(
          object.present_weight,
          memory.Distance(memory.Find(seen.frame)->input.world_from_cam, input.world_from_cam));
    }
    object.present_weight *= Judge(object, input, occluders).telling;
  }
  PoseSampler sampler(map, options(), PosteriorOf(object, input, occluders),
                      Key(setup.seed, input.frame, object.id, Draw::kSearch));
  Population population =
      Rejudge(object, last, static_cast<int>(object.particles.size()), sampler, input.frame);
  std::vector<PoseHypothesis> challengers =
      sampler.Challengers(population.hypotheses, kChallengerCount);
  challengers.insert(challengers.end(), object.joined.begin(), object.joined.end());
  object.joined.clear();
  if (object.last_proposal) {
    const std::vector<PoseHypothesis> newcomers = SampleBirth(
        *object.last_proposal, setup.camera, object.world_from_proposal_cam, map, options(),
        kNewcomerCount, Key(setup.seed, input.frame, object.id, Draw::kNewcomers));
    challengers.insert(challengers.end(), newcomers.begin(), newcomers.end());
  }
  const std::vector<ProposalMode> modes =
      sampler.FindModes(population, challengers, object.sharpness);
  // Many accept where there is somewhere better to be: those that drew badly draw again.
  if (sampler.Jump(population, modes) > kManyJumped) sampler.Jump(population, modes);
  sampler.Walk(population);
  Take(object, population);
  if (!tentative && !modes.empty())
    GiveLeeway(object, population, modes, ViewsOf(object, input, occluders), sampler);
  Summarize(object, input);
  if (!tentative || IsPlaced(object)) {
    object.outline_covariance = OutlineErrorOf(object, input, occluders);
    Summarize(object, input);
  }
  if (!tentative) return;
  const RememberedLooks looks = LookBack(object, input, occluders);
  object.remembered_evidence = looks.evidence;
  object.remembered_boxes = looks.boxes;
  // What passes has shown best before it is known where it stands.
  if (map.LengthScale(object.mean().label) > 1 && BeliefInMean(object) >= kInDoubt)
    object.shown = std::max(object.shown, looks.shown);
}

}  // namespace plumbline
