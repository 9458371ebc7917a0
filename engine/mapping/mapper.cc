// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/mapper.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "engine/base/timer.h"
#include "engine/geometry/angles.h"
#include "engine/mapping/association.h"
#include "engine/mapping/birth.h"
#include "engine/mapping/bytes.h"
#include "engine/mapping/map_object.h"
#include "engine/mapping/existence.h"
#include "engine/mapping/judging.h"
#include "engine/mapping/novelty_clock.h"

namespace plumbline {
namespace {

constexpr double kFirstFrame_s = 1.0 / 30.0;
constexpr double kMinViewVisibility = 0.15;  ///< Of a contour, in a view worth remembering.
constexpr double kMarginalSharpness = 5;
constexpr double kSamePose_m = 0.15, kSamePose_rad = 30 * kRadPerDeg;
constexpr double kFocalOfOptions_px = 500;  ///< Areas in pixels are of such a camera.
constexpr double kSearchRelaxation = 8.0;  ///< An object is searched for about so often as it ages by e.
constexpr std::size_t kTurnedChallengers = 160;
constexpr int kNewcomerCount = 100;
constexpr double kManyJumped = 0.3;
constexpr double kLooksBeforeMerging = 1;
constexpr std::size_t kJoined = 60;  ///< Poses that a merged object leaves, about.
constexpr double kSpawnReach = 2.0;  // at half size: four times as far as later

/// What a random draw is for: each has numbers of its own.
enum class Draw : std::uint32_t { kDiffuse, kResample, kSample, kBirth, kNewcomers, kSearch };

RandomKey Key(std::uint64_t seed, int frame, ObjectId object, Draw draw) {
  return {seed, static_cast<std::uint32_t>(frame),
          static_cast<std::uint32_t>(object.value) * 8 + static_cast<std::uint32_t>(draw), 0};
}

std::vector<PoseHypothesis> ToHypotheses(const std::vector<Particle>& particles,
                                         const Eigen::Isometry3d& world_from_reference_cam) {
  std::vector<PoseHypothesis> hypotheses;
  hypotheses.reserve(particles.size());
  for (const Particle& particle : particles)
    hypotheses.push_back(ToHypothesis(particle, world_from_reference_cam));
  return hypotheses;
}

std::vector<Particle> ToParticles(const std::vector<PoseHypothesis>& hypotheses,
                                  const Eigen::Isometry3d& world_from_reference_cam) {
  std::vector<Particle> particles;
  particles.reserve(hypotheses.size());
  for (const PoseHypothesis& hypothesis : hypotheses) {
    particles.push_back(ToParticle(hypothesis, world_from_reference_cam));
    particles.back().log_weight = -std::log(static_cast<float>(hypotheses.size()));
    particles.back().ancestor = static_cast<std::uint16_t>(particles.size() - 1);
  }
  return particles;
}

}  // namespace

struct Mapper::Impl {
  MapperSetup setup;
  MapFrame map;
  std::unique_ptr<OcclusionRenderer> renderer;
  KeyFrameMemory memory;
  std::vector<MapObject> objects;
  std::int32_t next_object_id = 1;
  std::optional<std::int64_t> last_stamp_ns;
  NoveltyClock clock;
  RenderedMaps mean_maps;

  Impl(const MapperSetup& s, std::unique_ptr<OcclusionRenderer> r)
      : setup(s),
        map{UprightFrame(s.gravity_in_world), s.floor_in_world, s.database},
        renderer(std::move(r)),
        memory(s.camera, s.options) {}

  const MapperOptions& options() const { return setup.options; }

  std::vector<PlacedModel> MeanStates(bool confirmed_only) const {
    std::vector<PlacedModel> placed;
    for (const MapObject& object : objects) {
      if (confirmed_only && object.state != ObjectState::kConfirmed) continue;
      placed.push_back({object.id, object.mean().label, object.mean().world_from_object});
    }
    return placed;
  }

  ScoringView View(const MapperInput& input, const RenderedMaps& occluders, ObjectId object) const {
    ScoringView view;
    view.camera = setup.camera;
    view.cam_from_world = input.world_from_cam.inverse();
    view.table = input.table.get();
    view.occluder_depth = OccluderDepth(occluders, object);
    view.occlusion_margin_m = options().occlusion_margin_m;
    view.inner_lines = options().inner_lines;
    return view;
  }

  Likelihood AtMean(const MapObject& object, const ScoringView& view,
                    const FrameDetections* detections) const {
    const PoseHypothesis mean = ToHypothesis(object.mean(), map);
    return Evaluate(*setup.scorer, view, map, detections, {&mean, 1}, std::nullopt, options())
        .front();
  }

  /// How an image judges hypotheses of the object, and what it shows of the object's mean.
  struct Judging {
    JudgingView view;
    double visible_fraction = 0;
    double telling = 0;  ///< In [0, 1]: a small or hidden contour says less than a long one.
  };
  Judging Judge(const MapObject& object, const MapperInput& from, const RenderedMaps& maps) const {
    Judging result{{View(from, maps, object.id), from.detections.get(), 0, 1}, 0, 0};
    const PoseHypothesis mean = ToHypothesis(object.mean(), map);
    HypothesisScore score;
    setup.scorer->Score(result.view.view, map.upright, {&mean, 1}, {&score, 1});
    result.view.normalizer = EdgeNormalizer({&score, 1});
    result.visible_fraction = score.total_m > 0 ? score.visible_m / score.total_m : 0;
    const double depth = (result.view.view.cam_from_world * mean.center_in_world).z();
    if (depth > 0) {
      result.telling = std::min(
          1.0, score.visible_m * kFocalOfOptions_px / depth / options().telling_contour_px);
    }
    return result;
  }

  // Steps of a frame, in order.
  void UpdateWeights(MapObject& object, const MapperInput& input, const RenderedMaps& occluders,
                     double dt_s, double novelty, FrameReport& report);
  void UpdateExistence(MapObject& object, const MapperInput& input, const RenderedMaps& occluders,
                       const Detection* matched, double dt_s, double novelty);
  /// Share of the box of the object's bounds that lies inside the image.
  double InsideFraction(const PoseHypothesis& mean, const MapperInput& input) const;
  /// Its posterior with the views it remembers, and the present frame.
  Target PosteriorOf(const MapObject& object, const MapperInput& input,
                     const RenderedMaps& occluders) const;
  /// Equally weighted particles, judged anew: what hides the object in past views may be known
  /// better by now.
  Population Rejudge(MapObject& object, const std::vector<double>& last, int count,
                     const PoseSampler& sampler, int frame);
  /// Of the object's particles, as its weights have it.
  std::vector<double> LogLikelihoods(const MapObject& object) const;
  void Take(MapObject& object, const Population& population);
  /// The key frames that show the object from the most different sides, for as many as it remembers.
  std::vector<const KeyFrame*> ChooseViews(const MapObject& object) const;
  void Remember(MapObject& object, int frame, double weight);
  void Search(MapObject& object, const MapperInput& input, const RenderedMaps& occluders);
  void Spawn(std::vector<ProposalReport>& proposals, const MapperInput& input,
             const RenderedMaps& occluders, FrameReport& report);
  std::optional<MapObject> Spawn(const ProposalReport& proposal, const MapperInput& input,
                                 const OrientedTable& wide_table, const RenderedMaps& occluders);
  void UpdateLifecycle(const MapperInput& input, double novelty, FrameReport& report);
  void KeepFrame(const MapperInput& input);
  /// Share of the particles near the mean pose, whatever their shape.
  double BeliefInMean(const MapObject& object) const;
  void MergeDuplicates(double novelty, FrameReport& report);
  void Retire(MapObject& object, EventKind kind, ObjectId other, std::string why,
              FrameReport& report);
};

void Mapper::Impl::UpdateWeights(MapObject& object, const MapperInput& input,
                                 const RenderedMaps& occluders, double dt_s, double novelty,
                                 FrameReport& report) {
  const ScoringView view = View(input, occluders, object.id);
  const Likelihood before = AtMean(object, view, nullptr);
  object.visible_fraction = before.visible_fraction;
  object.whole_box = before.whole_box;
  object.visible_box = before.visible_box;
  object.updated = before.visible_fraction >= options().min_visible;
  if (!object.updated) return;

  const ModelId label_before = object.mean().label;
  const bool remembers = options().key_frames > 0;
  if (!remembers) {
    Diffuse(object.particles, object.world_from_reference_cam, map, dt_s, options(),
            Key(setup.seed, input.frame, object.id, Draw::kDiffuse));
  }
  const std::vector<PoseHypothesis> hypotheses =
      ToHypotheses(object.particles, object.world_from_reference_cam);
  const Judging now = Judge(object, input, occluders);
  const std::vector<Likelihood> likelihoods =
      Evaluate(*setup.scorer, view, map, input.detections.get(), hypotheses, now.view.normalizer,
               options());
  // The present frame takes the place of the last one: together with the remembered views it is
  // worth what its viewpoint adds to them. Without memory, frames count for what each adds.
  double weight = remembers ? 1.0 : novelty;
  for (const ObjectView& seen : object.views) {
    if (const KeyFrame* key = memory.Find(seen.frame)) {
      weight = std::min(weight, memory.Distance(key->input.world_from_cam, input.world_from_cam));
    }
  }
  const std::vector<double> last = LogLikelihoods(object);
  object.present_weight = weight * now.telling;
  for (std::size_t i = 0; i < object.particles.size(); ++i) {
    object.particles[i].phi_cnn = likelihoods[i].phi_cnn;
    object.particles[i].phi_edge = likelihoods[i].phi_edge;
    object.particles[i].ancestor = static_cast<std::uint16_t>(i);
  }
  const std::vector<double> present = LogLikelihoods(object);
  for (std::size_t i = 0; i < object.particles.size(); ++i) {
    object.particles[i].log_weight +=
        static_cast<float>(remembers ? present[i] - last[i] : present[i]);
  }
  NormalizeLogWeights(object.particles);
  object.effective_sample_size = EffectiveSampleSize(object.particles);
  const int wanted =
      object.state == ObjectState::kConfirmed ? options().particles : options().tentative_particles;
  const bool low = object.effective_sample_size <
                   options().resample_below * static_cast<double>(object.particles.size());
  if (options().resample == ResampleRule::kEveryFrame || low ||
      static_cast<int>(object.particles.size()) != wanted) {
    if (remembers) {
      PoseSampler sampler(map, options(), PosteriorOf(object, input, occluders),
                          Key(setup.seed, input.frame, object.id, Draw::kSample));
      Population population =
          Rejudge(object, LogLikelihoods(object), wanted, sampler, input.frame);
      sampler.Walk(population);
      Take(object, population);
    } else {
      object.particles =
          SystematicResample(object.particles, wanted,
                             Key(setup.seed, input.frame, object.id, Draw::kResample));
      object.memory.assign(object.particles.size(), 0.0f);
    }
  }
  object.Summarize(map);

  const Likelihood after = AtMean(object, view, input.detections.get());
  object.phi_cnn = after.phi_cnn;
  object.phi_edge = after.phi_edge;
  object.visible_fraction = after.visible_fraction;
  object.whole_box = after.whole_box;
  object.visible_box = after.visible_box;
  object.last_frame = input.frame;
  object.seen_s += dt_s;
  if (object.mean().label != label_before) {
    report.events.push_back({EventKind::kLabelChanged,
                             object.id,
                             {},
                             "now most likely " + setup.database->model(object.mean().label).name});
  }
}

void Mapper::Impl::UpdateExistence(MapObject& object, const MapperInput& input,
                                   const RenderedMaps& occluders, const Detection* matched,
                                   double dt_s, double novelty) {
  const ScoringView view = View(input, occluders, object.id);
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  // What all particles together expect of this image, not the mean alone: it may be between modes.
  double expected = 0;
  for (const Particle& particle : object.particles)
    expected += std::exp(particle.log_weight + kMarginalSharpness * particle.phi_edge);
  const double marginal = std::log(expected) / kMarginalSharpness;
  const double focal = kFocalOfOptions_px / setup.camera.fx;
  Sighting sighting;
  sighting.novelty = novelty;
  sighting.visible_px = object.visible_box.area() * focal * focal;
  sighting.visible_fraction = object.visible_fraction;
  sighting.telling = Judge(object, input, occluders).telling;
  sighting.inside_fraction = InsideFraction(mean, input);
  if (matched != nullptr) {
    sighting.box_score = matched->score;
    sighting.box_iou = Iou(matched->box, object.visible_box);
  }
  sighting.edge_surplus = EdgeSurplus(*setup.scorer, view, map, mean) +
                          static_cast<float>(std::max(0.0, marginal - object.phi_edge));
  if (sighting.edge_surplus > options().expected_edge &&
      object.visible_fraction >= options().confirm_shown) {
    object.shown += novelty;
  }
  Existence existence{object.log_evidence, object.hidden};
  // Only what has been seen to be there can be said to be hidden.
  if (object.state == ObjectState::kConfirmed) {
    existence.Update(sighting, dt_s, options());
  } else {
    existence.UpdateInView(sighting, options());
  }
  object.log_evidence = existence.log_odds;
  object.hidden = existence.hidden;
}

double Mapper::Impl::InsideFraction(const PoseHypothesis& mean, const MapperInput& input) const {
  const std::optional<Box2> whole = ProjectedBounds(setup.database->model(mean.label), mean, map,
                                                    setup.camera, input.world_from_cam.inverse());
  if (!whole) return 0;
  const Box2 image{0, 0, static_cast<float>(setup.camera.width - 1),
                   static_cast<float>(setup.camera.height - 1)};
  return Intersection(*whole, image).area() / std::max(1.0f, whole->area());
}

Target Mapper::Impl::PosteriorOf(const MapObject& object, const MapperInput& input,
                                 const RenderedMaps& occluders) const {
  std::vector<JudgingView> remembered;
  for (const ObjectView& seen : object.views) {
    const KeyFrame* key = memory.Find(seen.frame);
    if (key == nullptr) continue;
    remembered.push_back(Judge(object, key->input, key->maps).view);
    remembered.back().weight = seen.weight;
  }
  JudgingView present = Judge(object, input, occluders).view;
  present.weight = object.present_weight;
  return Posterior(*setup.scorer, map, std::move(remembered), present, options());
}

std::vector<double> Mapper::Impl::LogLikelihoods(const MapObject& object) const {
  const double sum = object.remembered() + object.present_weight;
  const double scale = sum > 0 ? IndependentViews(sum, options().view_correlation) / sum : 0.0;
  std::vector<double> result;
  for (std::size_t i = 0; i < object.particles.size(); ++i) {
    const Particle& particle = object.particles[i];
    result.push_back(scale * (object.memory[i] + object.present_weight *
                                                     (options().alpha * particle.phi_cnn +
                                                      options().beta * particle.phi_edge)));
  }
  return result;
}

Population Mapper::Impl::Rejudge(MapObject& object, const std::vector<double>& last, int count,
                                 const PoseSampler& sampler, int frame) {
  const std::vector<PoseHypothesis> hypotheses =
      ToHypotheses(object.particles, object.world_from_reference_cam);
  const std::vector<Judgement> judged = sampler.Judge(hypotheses);
  for (std::size_t i = 0; i < judged.size(); ++i) {
    object.memory[i] = judged[i].memory;
    object.particles[i].phi_cnn = judged[i].phi_cnn;
    object.particles[i].phi_edge = judged[i].phi_edge;
  }
  const std::vector<double> now = LogLikelihoods(object);
  for (std::size_t i = 0; i < judged.size(); ++i)
    object.particles[i].log_weight += static_cast<float>(now[i] - last[i]);
  NormalizeLogWeights(object.particles);
  Population population;
  for (const Particle& particle :
       SystematicResample(object.particles, count,
                          Key(setup.seed, frame, object.id, Draw::kResample))) {
    population.hypotheses.push_back(hypotheses[particle.ancestor]);
    population.judged.push_back(judged[particle.ancestor]);
  }
  return population;
}

void Mapper::Impl::Take(MapObject& object, const Population& population) {
  object.particles = ToParticles(population.hypotheses, object.world_from_reference_cam);
  object.memory.clear();
  for (std::size_t i = 0; i < population.size(); ++i) {
    object.particles[i].phi_cnn = population.judged[i].phi_cnn;
    object.particles[i].phi_edge = population.judged[i].phi_edge;
    object.memory.push_back(population.judged[i].memory);
  }
}

std::vector<const KeyFrame*> Mapper::Impl::ChooseViews(const MapObject& object) const {
  std::vector<const KeyFrame*> rest, chosen;
  for (const KeyFrame& key : memory.frames()) {
    if (Judge(object, key.input, key.maps).visible_fraction >= kMinViewVisibility)
      rest.insert(rest.begin(), &key);  // from the newest back
  }
  while (!rest.empty() && static_cast<int>(chosen.size()) < options().views_per_object) {
    std::size_t pick = 0;
    double furthest = -1;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const KeyFrame* other : chosen) {
        nearest = std::min(nearest, (rest[i]->input.world_from_cam.translation() -
                                     other->input.world_from_cam.translation())
                                        .norm());
      }
      if (nearest > furthest) {
        furthest = nearest;
        pick = i;
      }
    }
    chosen.push_back(rest[pick]);
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(pick));
  }
  return chosen;
}

void Mapper::Impl::Remember(MapObject& object, int frame, double weight) {
  object.views.push_back({frame, weight});
  if (static_cast<int>(object.views.size()) <= options().views_per_object) return;
  // Of the two views that are closest to each other the older goes; the other stands for it.
  std::size_t drop = 0, heir = 1;
  double closest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < object.views.size(); ++i) {
    for (std::size_t j = i + 1; j < object.views.size(); ++j) {
      const KeyFrame *a = memory.Find(object.views[i].frame), *b = memory.Find(object.views[j].frame);
      const double d = a == nullptr || b == nullptr
                           ? 0.0
                           : memory.Distance(a->input.world_from_cam, b->input.world_from_cam);
      if (d < closest) {
        closest = d;
        drop = i;
        heir = j;
      }
    }
  }
  object.views[heir].weight += object.views[drop].weight;
  object.views.erase(object.views.begin() + static_cast<std::ptrdiff_t>(drop));
}

void Mapper::Impl::Search(MapObject& object, const MapperInput& input,
                          const RenderedMaps& occluders) {
  if (options().key_frames == 0 || !object.updated) return;
  const bool tentative = object.state == ObjectState::kTentative;
  // What has been seen for long has been searched for often: the search relaxes with age.
  const double period = tentative ? options().tentative_search_s
                                  : std::clamp(object.seen_s / kSearchRelaxation,
                                               options().tentative_search_s,
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
      object.present_weight =
          std::min(object.present_weight, memory.Distance(memory.Find(seen.frame)->input.world_from_cam,
                                                          input.world_from_cam));
    }
    object.present_weight *= Judge(object, input, occluders).telling;
  }
  PoseSampler sampler(map, options(), PosteriorOf(object, input, occluders),
                      Key(setup.seed, input.frame, object.id, Draw::kSearch));
  Population population =
      Rejudge(object, last, static_cast<int>(object.particles.size()), sampler, input.frame);
  std::vector<PoseHypothesis> challengers =
      sampler.Challengers(population.hypotheses, kTurnedChallengers);
  challengers.insert(challengers.end(), object.joined.begin(), object.joined.end());
  object.joined.clear();
  if (object.last_proposal) {
    const std::vector<PoseHypothesis> newcomers = SampleBirth(
        *object.last_proposal, setup.camera, object.world_from_proposal_cam, map, options(),
        kNewcomerCount, Key(setup.seed, input.frame, object.id, Draw::kNewcomers));
    challengers.insert(challengers.end(), newcomers.begin(), newcomers.end());
  }
  const std::vector<ProposalMode> modes = sampler.FindModes(population, challengers);
  // Many accept where there is somewhere better to be: those that drew badly draw again.
  if (sampler.Jump(population, modes) > kManyJumped) sampler.Jump(population, modes);
  sampler.Walk(population);
  Take(object, population);
  object.Summarize(map);
}

std::optional<MapObject> Mapper::Impl::Spawn(const ProposalReport& proposal,
                                             const MapperInput& input,
                                             const OrientedTable& wide_table,
                                             const RenderedMaps& occluders) {
  MapObject object;
  object.id = ObjectId{next_object_id};
  object.category = proposal.category;
  object.reference_frame = object.first_frame = object.last_frame = input.frame;
  object.world_from_reference_cam = input.world_from_cam;
  object.last_proposal = Detection{proposal.box, proposal.category, proposal.score};
  object.world_from_proposal_cam = input.world_from_cam;
  std::vector<PoseHypothesis> drawn =
      SampleBirth(*object.last_proposal, setup.camera, input.world_from_cam, map, options(),
                  options().spawn_particles, Key(setup.seed, input.frame, object.id, Draw::kBirth));
  if (drawn.empty()) return std::nullopt;
  // A wide search picks the neighbourhoods worth a closer look; its weights are those of half an
  // independent view.
  JudgingView wide{View(input, occluders, object.id), nullptr, 0, 0.5};
  wide.view.camera = setup.camera.Scaled(0.5);
  wide.view.table = &wide_table;
  std::vector<HypothesisScore> scores(drawn.size());
  setup.scorer->Score(wide.view, map.upright, drawn, scores);
  wide.normalizer = EdgeNormalizer(scores);
  MapperOptions exact = options();
  exact.view_correlation = 0;
  PoseSampler sampler(map, options(), Posterior(*setup.scorer, map, {}, wide, exact),
                      Key(setup.seed, input.frame, object.id, Draw::kSample));
  Population population =
      sampler.Temper(drawn, static_cast<std::size_t>(options().tentative_particles));
  for (Judgement& judged : population.judged) judged.memory = 0;
  Take(object, population);
  object.effective_sample_size = EffectiveSampleSize(object.particles);
  object.Summarize(map);
  object.updated = true;
  return object;
}

void Mapper::Impl::Spawn(std::vector<ProposalReport>& proposals, const MapperInput& input,
                         const RenderedMaps& occluders, FrameReport& report) {
  int tentative = 0;
  for (const MapObject& object : objects)
    tentative += object.state == ObjectState::kTentative ? 1 : 0;
  int births = 0;
  std::vector<std::pair<Box2, ObjectId>> born;
  std::shared_ptr<const OrientedTable> wide_table;
  for (ProposalReport& proposal : proposals) {
    if (proposal.fate != ProposalFate::kSpawned) continue;
    const auto same = std::find_if(born.begin(), born.end(), [&](const auto& other) {
      const float shared = Intersection(other.first, proposal.box).area();
      return shared >
             options().explained_overlap * std::min(other.first.area(), proposal.box.area());
    });
    if (same != born.end()) {
      proposal.fate = ProposalFate::kExplained;
      proposal.object = same->second;
      continue;
    }
    if (tentative >= options().max_tentative || births >= options().max_spawns_per_frame) {
      proposal.fate = ProposalFate::kLowScore;
      continue;
    }
    if (!wide_table) wide_table = SearchTable(HalfSize(input.edges), options(), setup.camera.fx, kSpawnReach);
    std::optional<MapObject> object = Spawn(proposal, input, *wide_table, occluders);
    if (!object) {
      proposal.fate = ProposalFate::kImplausible;
      continue;
    }
    ++next_object_id;
    ++tentative;
    ++births;
    proposal.object = object->id;
    born.emplace_back(proposal.box, object->id);
    report.events.push_back(
        {EventKind::kSpawned, object->id, {}, "an unexplained " + proposal.category + " box"});
    objects.push_back(std::move(*object));
  }
}

void Mapper::Impl::Retire(MapObject& object, EventKind kind, ObjectId other, std::string why,
                          FrameReport& report) {
  object.state = ObjectState::kRetired;
  report.events.push_back({kind, object.id, other, std::move(why)});
}

void Mapper::Impl::UpdateLifecycle(const MapperInput& input, double novelty, FrameReport& report) {
  for (MapObject& object : objects) {
    if (object.state == ObjectState::kRetired || !object.updated) continue;
    if (object.log_evidence < options().retire_evidence) {
      Retire(object, EventKind::kRetired, {}, "seen where it should show, without support", report);
    } else if (object.state == ObjectState::kTentative &&
               object.log_evidence > options().confirm_evidence &&
               object.seen_s > options().confirm_age_s &&
               object.mean().position_std_m < options().confirm_position_std_m &&
               BeliefInMean(object) >= options().confirm_mode_weight &&
               object.shown >= 1) {
      object.state = ObjectState::kConfirmed;
      object.confirmed_frame = input.frame;
      report.events.push_back({EventKind::kConfirmed, object.id, {}, "evidence has accumulated"});
    } else if (object.state == ObjectState::kTentative &&
               object.seen_s > options().tentative_limit_s) {
      Retire(object, EventKind::kRetired, {}, "tentative for too long", report);
    }
  }
  MergeDuplicates(novelty, report);
}

double Mapper::Impl::BeliefInMean(const MapObject& object) const {
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  double sum = 0;
  for (const PoseMode& mode : object.modes) {
    const PoseHypothesis other = ToHypothesis(mode, map);
    const Eigen::Vector3d offset = other.center_in_world - mean.center_in_world;
    if (offset.norm() < kSamePose_m &&
        std::abs(AzimuthDifference(setup.database->model(mean.label), other.azimuth_rad,
                                   mean.azimuth_rad)) < kSamePose_rad) {
      sum += mode.weight;
    }
  }
  return sum;
}

void Mapper::Impl::MergeDuplicates(double novelty, FrameReport& report) {
  const auto settled = [&](const MapObject& object) {
    return object.state == ObjectState::kConfirmed ||
           (object.state == ObjectState::kTentative && object.seen_s > options().tentative_search_s);
  };
  for (std::size_t i = 0; i < objects.size(); ++i) {
    MapObject* rival = nullptr;
    MapObject& a = objects[i];
    if (!settled(a)) continue;  // also what was merged just now
    for (std::size_t j = 0; j < objects.size() && rival == nullptr; ++j) {
      if (j != i && settled(objects[j]) && Compete(a, objects[j], map)) rival = &objects[j];
    }
    if (rival == nullptr) {
      a.rival = {};
      a.rivalry = 0;
      continue;
    }
    // One look may mislead, several do not.
    a.rivalry = (a.rival == rival->id ? a.rivalry : 0) + novelty;
    a.rival = rival->id;
    if (a.rivalry < kLooksBeforeMerging) continue;
    const auto rank = [](const MapObject& object) {
      return std::make_tuple(object.state == ObjectState::kConfirmed, object.log_evidence,
                             -object.id.value);
    };
    MapObject& winner = rank(a) > rank(*rival) ? a : *rival;
    MapObject& loser = rank(a) > rank(*rival) ? *rival : a;
    // The loser's poses go on as the winner's: its next search weighs them by all that it has seen.
    for (std::size_t k = 0; k < loser.particles.size(); k += loser.particles.size() / kJoined + 1)
      winner.joined.push_back(ToHypothesis(loser.particles[k], loser.world_from_reference_cam));
    Retire(loser, EventKind::kMerged, winner.id,
           "object " + std::to_string(winner.id.value) + " stands there and is better founded", report);
  }
}

void Mapper::Impl::KeepFrame(const MapperInput& input) {
  if (options().key_frames == 0) return;
  const KeyFrameMemory::Offered offered = memory.Offer(input);
  if (offered.kept) {
    for (MapObject& object : objects) {
      if (object.state == ObjectState::kRetired || !object.updated ||
          object.last_frame != input.frame || object.visible_fraction < kMinViewVisibility) {
        continue;
      }
      for (std::size_t i = 0; i < object.particles.size(); ++i) {
        const Particle& particle = object.particles[i];
        object.memory[i] += static_cast<float>(
            object.present_weight *
            (options().alpha * particle.phi_cnn + options().beta * particle.phi_edge));
      }
      Remember(object, input.frame, object.present_weight);
      object.present_weight = 0;
    }
  }
  for (const int frame : offered.forgotten) {
    for (MapObject& object : objects) {
      std::erase_if(object.views, [&](const ObjectView& view) { return view.frame == frame; });
    }
  }
}

Mapper::Mapper(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Mapper::~Mapper() = default;

Result<std::unique_ptr<Mapper>> Mapper::Create(const MapperSetup& setup) {
  PLB_CHECK(setup.database != nullptr && setup.scorer != nullptr);
  if (setup.database->models().empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "the model folder '" + setup.database->folder().string() + "' has no models"};
  }
  Result<std::unique_ptr<OcclusionRenderer>> renderer = OcclusionRenderer::Create(setup.database);
  if (!renderer.ok()) return renderer.error();
  return std::unique_ptr<Mapper>(
      new Mapper(std::make_unique<Impl>(setup, std::move(renderer).value())));
}

FrameReport Mapper::Step(const MapperInput& input) {
  Impl& m = *impl_;
  FrameReport report;
  report.frame = input.frame;
  report.stamp_ns = input.stamp_ns;
  report.world_from_cam = input.world_from_cam;
  const double dt_s = m.last_stamp_ns
                          ? static_cast<double>(input.stamp_ns - *m.last_stamp_ns) * 1e-9
                          : kFirstFrame_s;
  PLB_CHECK(dt_s > 0) << "frames come in time order";
  m.last_stamp_ns = input.stamp_ns;
  const double novelty = m.clock.Advance(input.stamp_ns, input.world_from_cam, m.options());
  std::erase_if(m.objects,
                [](const MapObject& object) { return object.state == ObjectState::kRetired; });

  Stopwatch watch;
  const std::vector<PlacedModel> occluders = m.MeanStates(true);
  const RenderedMaps occlusion =
      m.renderer->Render(m.setup.camera, input.world_from_cam.inverse(), occluders);
  m.memory.UpdateOcclusion(*m.renderer, occluders);
  report.timings.push_back({"visibility", watch.Lap()});
  for (MapObject& object : m.objects) m.UpdateWeights(object, input, occlusion, dt_s, novelty, report);
  report.timings.push_back({"update", watch.Lap()});
  for (MapObject& object : m.objects) m.Search(object, input, occlusion);
  report.timings.push_back({"search", watch.Lap()});
  m.mean_maps =
      m.renderer->Render(m.setup.camera, input.world_from_cam.inverse(), m.MeanStates(false));
  const std::span<const Detection> detections =
      input.detections ? input.detections->proposals() : std::span<const Detection>{};
  const std::vector<std::optional<std::size_t>> matched =
      MatchProposals(detections, m.objects, m.mean_maps);
  report.proposals = ExplainProposals(detections, m.objects, matched, m.mean_maps,
                                      *m.setup.database, m.options());
  for (std::size_t i = 0; i < m.objects.size(); ++i) {
    MapObject& object = m.objects[i];
    const Detection* detection = matched[i] ? &detections[*matched[i]] : nullptr;
    if (detection != nullptr) {
      object.last_proposal = *detection;
      object.world_from_proposal_cam = input.world_from_cam;
    }
    if (object.updated) m.UpdateExistence(object, input, occlusion, detection, dt_s, novelty);
  }
  report.timings.push_back({"explain", watch.Lap()});
  m.Spawn(report.proposals, input, occlusion, report);
  report.timings.push_back({"spawn", watch.Lap()});
  m.UpdateLifecycle(input, novelty, report);
  m.KeepFrame(input);

  for (const MapObject& object : m.objects) report.objects.push_back(ToReport(object));
  report.next_object_id = m.next_object_id;
  ByteWriter state;
  m.clock.Save(state);
  report.mapper_state = state.Take() + m.memory.Save();
  return report;
}

Status Mapper::Restore(const FrameReport& report,
                       const std::function<Result<MapperInput>(int)>& load) {
  Impl& m = *impl_;
  m.objects.clear();
  if (report.mapper_state.empty()) return {};  // every frame so far was skipped
  for (const ObjectReport& object : report.objects) {
    Result<MapObject> restored = FromReport(object);
    if (!restored.ok()) return restored.error();
    m.objects.push_back(std::move(restored).value());
  }
  m.next_object_id = report.next_object_id;
  m.last_stamp_ns = report.stamp_ns;
  ByteReader state(report.mapper_state);
  m.clock.Restore(state);
  return m.memory.Restore(state.rest(), load, *m.renderer);
}

void Mapper::SetOptions(const MapperOptions& options) {
  impl_->setup.options = options;
  impl_->memory.SetOptions(options);
}

const RenderedMaps& Mapper::mean_maps() const { return impl_->mean_maps; }

RenderedMaps Mapper::RenderMeans(const FrameReport& report) {
  if (!report.world_from_cam) return {};
  std::vector<PlacedModel> placed;
  for (const ObjectReport& object : report.objects) {
    if (object.state != ObjectState::kRetired)
      placed.push_back({object.id, object.label, object.world_from_object});
  }
  return impl_->renderer->Render(impl_->setup.camera, report.world_from_cam->inverse(), placed);
}

}  // namespace plumbline
