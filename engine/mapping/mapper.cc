// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/mapper.h"

#include <algorithm>
#include <cmath>

#include "engine/base/timer.h"
#include "engine/mapping/association.h"
#include "engine/mapping/birth.h"
#include "engine/mapping/bytes.h"
#include "engine/mapping/map_object.h"
#include "engine/mapping/move.h"

namespace plumbline {
namespace {

constexpr double kFirstFrame_s = 1.0 / 30.0;
constexpr double kMinKeyFrameVisibility = 0.15;
constexpr double kMaxEvidence = 15.0;
constexpr double kMoveFramesPerSecondSeen = 4.0;
constexpr double kMostEdgeSurplus = 0.22, kMostDetectorSurplus = 0.1;
constexpr double kSpawnReach = 2.0;  // at half size: four times as far as later

/// What a random draw is for: each has numbers of its own.
enum class Draw : std::uint32_t { kDiffuse, kResample, kMove, kBirth, kNewcomers, kSpread };

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
    return view;
  }

  Likelihood AtMean(const MapObject& object, const ScoringView& view,
                    const FrameDetections* detections) const {
    const PoseHypothesis mean = ToHypothesis(object.mean(), map);
    return Evaluate(*setup.scorer, view, map, detections, {&mean, 1}, std::nullopt, options())
        .front();
  }

  // Steps of a frame, in order.
  void UpdateWeights(MapObject& object, const MapperInput& input, const RenderedMaps& occluders,
                     double dt_s, FrameReport& report);
  void Resample(MapObject& object, int frame);
  std::vector<JudgingView> JudgingViews(const MapObject& object, const KeyFrameMemory& judges,
                                        const MapperInput& input,
                                        const RenderedMaps& occluders) const;
  void Move(MapObject& object, const MapperInput& input, const RenderedMaps& occluders);
  void Associate(const std::vector<ProposalReport>& proposals, const MapperInput& input);
  void Spawn(std::vector<ProposalReport>& proposals, const MapperInput& input,
             const RenderedMaps& occluders, FrameReport& report);
  std::optional<MapObject> Spawn(const ProposalReport& proposal, const MapperInput& input,
                                 const OrientedTable& wide_table, const RenderedMaps& occluders);
  void UpdateLifecycle(const MapperInput& input, FrameReport& report);
  void MergeDuplicates(const MapperInput& input, FrameReport& report);
  /// Whether b explains the images better than a.
  bool Stronger(const MapObject& a, const MapObject& b, const MapperInput& input);
  void Retire(MapObject& object, EventKind kind, ObjectId other, std::string why,
              FrameReport& report);
};

void Mapper::Impl::UpdateWeights(MapObject& object, const MapperInput& input,
                                 const RenderedMaps& occluders, double dt_s, FrameReport& report) {
  const ScoringView view = View(input, occluders, object.id);
  const Likelihood before = AtMean(object, view, nullptr);
  object.visible_fraction = before.visible_fraction;
  object.whole_box = before.whole_box;
  object.visible_box = before.visible_box;
  object.updated = before.visible_fraction >= options().min_visible;
  if (!object.updated) return;

  const ModelId label_before = object.mean().label;
  Diffuse(object.particles, object.world_from_reference_cam, map, dt_s, options(),
          Key(setup.seed, input.frame, object.id, Draw::kDiffuse));
  const std::vector<PoseHypothesis> hypotheses =
      ToHypotheses(object.particles, object.world_from_reference_cam);
  const std::vector<Likelihood> likelihoods = Evaluate(
      *setup.scorer, view, map, input.detections.get(), hypotheses, std::nullopt, options());
  // Consecutive frames are one measurement in so far as they are correlated.
  const double gain = std::min(1.0, dt_s / options().correlation_s);
  for (std::size_t i = 0; i < object.particles.size(); ++i) {
    Particle& particle = object.particles[i];
    particle.phi_cnn = likelihoods[i].phi_cnn;
    particle.phi_edge = likelihoods[i].phi_edge;
    particle.ancestor = static_cast<std::uint16_t>(i);
    particle.log_weight += static_cast<float>(
        gain * (options().alpha * particle.phi_cnn + options().beta * particle.phi_edge));
  }
  NormalizeLogWeights(object.particles);
  object.effective_sample_size = EffectiveSampleSize(object.particles);
  Resample(object, input.frame);
  object.Summarize(map);

  const Likelihood after = AtMean(object, view, input.detections.get());
  object.phi_cnn = after.phi_cnn;
  object.phi_edge = after.phi_edge;
  object.visible_fraction = after.visible_fraction;
  object.whole_box = after.whole_box;
  object.visible_box = after.visible_box;
  object.last_frame = input.frame;
  object.seen_s += dt_s;
  // A missing detection weighs more than all that can speak for the object: edges alone may be any
  // rectangle's, and a box says that something is there, not that it stands so.
  const double edge = options().evidence_per_edge *
                      std::min(after.phi_edge - options().expected_edge, kMostEdgeSurplus);
  const double cnn = options().evidence_per_cnn *
                     std::min(after.phi_cnn - options().expected_cnn, kMostDetectorSurplus);
  // Few visible edges say little either way.
  const double informative = std::min(1.0, after.visible_fraction / 0.3);
  object.log_evidence = std::clamp(object.log_evidence + gain * informative * (edge + cnn),
                                   -kMaxEvidence, kMaxEvidence);
  if (object.mean().label != label_before) {
    report.events.push_back({EventKind::kLabelChanged,
                             object.id,
                             {},
                             "now most likely " + setup.database->model(object.mean().label).name});
  }
}

void Mapper::Impl::Resample(MapObject& object, int frame) {
  const int wanted =
      object.state == ObjectState::kConfirmed ? options().particles : options().tentative_particles;
  const bool low = object.effective_sample_size <
                   options().resample_below * static_cast<double>(object.particles.size());
  if (options().resample == ResampleRule::kEveryFrame || low ||
      static_cast<int>(object.particles.size()) != wanted) {
    object.particles = SystematicResample(object.particles, wanted,
                                          Key(setup.seed, frame, object.id, Draw::kResample));
  }
}

std::vector<JudgingView> Mapper::Impl::JudgingViews(const MapObject& object,
                                                    const KeyFrameMemory& judges,
                                                    const MapperInput& input,
                                                    const RenderedMaps& occluders) const {
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  std::vector<JudgingView> views;
  std::vector<Eigen::Vector3d> cameras;
  const auto add = [&](const MapperInput& from, const RenderedMaps& maps) {
    JudgingView judging{View(from, maps, object.id), from.detections.get(), 0};
    HypothesisScore score;
    setup.scorer->Score(judging.view, map.upright, {&mean, 1}, {&score, 1});
    if (score.visible_m < kMinKeyFrameVisibility * score.total_m) return;
    judging.normalizer = EdgeNormalizer({&score, 1});
    views.push_back(std::move(judging));
    cameras.push_back(from.world_from_cam.translation());
  };
  add(input, occluders);
  // From the newest back; when there are more than needed, the ones that are furthest from those
  // taken.
  std::vector<const KeyFrame*> rest;
  for (const KeyFrame& key : judges.frames()) {
    if (key.input.frame != input.frame) rest.insert(rest.begin(), &key);
  }
  while (!rest.empty() && static_cast<int>(views.size()) < options().key_frames_per_move) {
    std::size_t pick = 0;
    double furthest = -1;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const Eigen::Vector3d& camera : cameras) {
        nearest = std::min(nearest, (rest[i]->input.world_from_cam.translation() - camera).norm());
      }
      if (nearest > furthest) {
        furthest = nearest;
        pick = i;
      }
    }
    add(rest[pick]->input, rest[pick]->maps);
    rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(pick));
  }
  return views;
}

void Mapper::Impl::Move(MapObject& object, const MapperInput& input,
                        const RenderedMaps& occluders) {
  const bool tentative = object.state == ObjectState::kTentative;
  // What has been seen for long has been moved often: the search relaxes with age.
  const int period =
      tentative ? options().tentative_move_period
                : std::clamp(static_cast<int>(kMoveFramesPerSecondSeen * object.seen_s),
                             options().tentative_move_period, options().confirmed_move_period);
  if (options().key_frames == 0 || !object.updated || input.frame - object.last_move_frame < period)
    return;
  const std::vector<JudgingView> views = JudgingViews(object, memory, input, occluders);
  if (views.empty()) return;
  object.last_move_frame = input.frame;
  MoveInput move;
  move.wide = true;
  // ResampleMove takes equally weighted particles.
  const int count = static_cast<int>(object.particles.size());
  move.particles =
      ToHypotheses(SystematicResample(object.particles, count,
                                      Key(setup.seed, input.frame, object.id, Draw::kSpread)),
                   object.world_from_reference_cam);
  if (object.last_proposal) {
    move.newcomers =
        SampleBirth(*object.last_proposal, setup.camera, object.world_from_proposal_cam, map,
                    options(), 150, Key(setup.seed, input.frame, object.id, Draw::kNewcomers));
  }
  object.particles = ToParticles(ResampleMove(*setup.scorer, map, views, move, count, options(),
                                              Key(setup.seed, input.frame, object.id, Draw::kMove)),
                                 object.world_from_reference_cam);
  // What this frame says of the new ones: for those who look at the run, not for the filter.
  const std::vector<Likelihood> likelihoods = Evaluate(
      *setup.scorer, View(input, occluders, object.id), map, input.detections.get(),
      ToHypotheses(object.particles, object.world_from_reference_cam), std::nullopt, options());
  for (std::size_t i = 0; i < object.particles.size(); ++i) {
    object.particles[i].phi_cnn = likelihoods[i].phi_cnn;
    object.particles[i].phi_edge = likelihoods[i].phi_edge;
  }
  object.Summarize(map);
}

void Mapper::Impl::Associate(const std::vector<ProposalReport>& proposals,
                             const MapperInput& input) {
  for (MapObject& object : objects) {
    float best = 0;
    for (const ProposalReport& proposal : proposals) {
      if (proposal.object != object.id || proposal.category != object.category) continue;
      const float iou = Iou(proposal.box, object.visible_box);
      if (iou <= best) continue;
      best = iou;
      object.last_proposal = Detection{proposal.box, proposal.category, proposal.score};
      object.world_from_proposal_cam = input.world_from_cam;
    }
  }
}

std::optional<MapObject> Mapper::Impl::Spawn(const ProposalReport& proposal,
                                             const MapperInput& input,
                                             const OrientedTable& wide_table,
                                             const RenderedMaps& occluders) {
  MapObject object;
  object.id = ObjectId{next_object_id};
  object.category = proposal.category;
  object.reference_frame = object.first_frame = object.last_frame = object.last_move_frame =
      input.frame;
  object.world_from_reference_cam = input.world_from_cam;
  object.last_proposal = Detection{proposal.box, proposal.category, proposal.score};
  object.world_from_proposal_cam = input.world_from_cam;
  std::vector<PoseHypothesis> drawn =
      SampleBirth(*object.last_proposal, setup.camera, input.world_from_cam, map, options(),
                  options().spawn_particles, Key(setup.seed, input.frame, object.id, Draw::kBirth));
  if (drawn.empty()) return std::nullopt;
  // A wide search picks the neighbourhoods worth a closer look; its weights are those of half an
  // independent frame.
  ScoringView view = View(input, occluders, object.id);
  view.camera = setup.camera.Scaled(0.5);
  view.table = &wide_table;
  const std::vector<Likelihood> likelihoods =
      Evaluate(*setup.scorer, view, map, nullptr, drawn, std::nullopt, options());
  object.particles = ToParticles(drawn, object.world_from_reference_cam);
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    object.particles[i].phi_edge = likelihoods[i].phi_edge;
    object.particles[i].log_weight +=
        static_cast<float>(0.5 * options().beta * likelihoods[i].phi_edge);
  }
  NormalizeLogWeights(object.particles);
  object.effective_sample_size = EffectiveSampleSize(object.particles);
  object.particles = SystematicResample(object.particles, options().tentative_particles,
                                        Key(setup.seed, input.frame, object.id, Draw::kResample));
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
    if (!wide_table) wide_table = SearchTable(HalfSize(input.edges), options(), kSpawnReach);
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

void Mapper::Impl::UpdateLifecycle(const MapperInput& input, FrameReport& report) {
  for (MapObject& object : objects) {
    if (object.state == ObjectState::kRetired || !object.updated) continue;
    if (object.log_evidence < options().retire_evidence) {
      Retire(object, EventKind::kRetired, {}, "seen where it should show, without support", report);
    } else if (object.state == ObjectState::kTentative &&
               object.log_evidence > options().confirm_evidence &&
               object.seen_s > options().confirm_age_s &&
               object.mean().position_std_m < options().confirm_position_std_m) {
      object.state = ObjectState::kConfirmed;
      object.confirmed_frame = input.frame;
      report.events.push_back({EventKind::kConfirmed, object.id, {}, "evidence has accumulated"});
    } else if (object.state == ObjectState::kTentative &&
               object.seen_s > options().tentative_limit_s) {
      Retire(object, EventKind::kRetired, {}, "tentative for too long", report);
    }
  }
  MergeDuplicates(input, report);
}

void Mapper::Impl::MergeDuplicates(const MapperInput& input, FrameReport& report) {
  const auto settled = [&](const MapObject& object) {
    return object.state == ObjectState::kConfirmed ||
           (object.state == ObjectState::kTentative &&
            input.frame - object.first_frame > options().tentative_move_period);
  };
  for (std::size_t i = 0; i < objects.size(); ++i) {
    for (std::size_t j = i + 1; j < objects.size(); ++j) {
      MapObject& a = objects[i];
      MapObject& b = objects[j];
      if (!settled(a) || !settled(b) || !Compete(a, b, map)) continue;
      const bool keep_b = Stronger(a, b, input);
      MapObject& loser = keep_b ? a : b;
      MapObject& winner = keep_b ? b : a;
      // What was known of the one is known of the other: the winner does not start again.
      if (loser.state == ObjectState::kConfirmed && winner.state == ObjectState::kTentative) {
        winner.state = ObjectState::kConfirmed;
        winner.confirmed_frame = input.frame;
        winner.log_evidence = std::max(winner.log_evidence, loser.log_evidence);
        report.events.push_back(
            {EventKind::kConfirmed, winner.id, loser.id,
             "explains the images better than object " + std::to_string(loser.id.value)});
      }
      Retire(loser, EventKind::kMerged, winner.id,
             "object " + std::to_string(winner.id.value) +
                 " stands there and explains the images better",
             report);
    }
  }
}

bool Mapper::Impl::Stronger(const MapObject& a, const MapObject& b, const MapperInput& input) {
  // Both are judged with neither of them hiding the other.
  std::vector<PlacedModel> others = MeanStates(true);
  std::erase_if(others, [&](const PlacedModel& placed) {
    return placed.object == a.id || placed.object == b.id;
  });
  KeyFrameMemory judges = memory;
  judges.UpdateOcclusion(*renderer, others);
  const RenderedMaps now = renderer->Render(setup.camera, input.world_from_cam.inverse(), others);
  std::vector<JudgingView> views = JudgingViews(a, judges, input, now);
  for (JudgingView& view : JudgingViews(b, judges, input, now)) views.push_back(std::move(view));
  const PoseHypothesis means[] = {ToHypothesis(a.mean(), map), ToHypothesis(b.mean(), map)};
  const std::vector<double> judged = JudgeHypotheses(*setup.scorer, map, views, means, options());
  return judged[1] > judged[0];
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
  std::erase_if(m.objects,
                [](const MapObject& object) { return object.state == ObjectState::kRetired; });

  Stopwatch watch;
  const std::vector<PlacedModel> occluders = m.MeanStates(true);
  const RenderedMaps occlusion =
      m.renderer->Render(m.setup.camera, input.world_from_cam.inverse(), occluders);
  m.memory.UpdateOcclusion(*m.renderer, occluders);
  report.timings.push_back({"visibility", watch.Lap()});
  for (MapObject& object : m.objects) m.UpdateWeights(object, input, occlusion, dt_s, report);
  report.timings.push_back({"update", watch.Lap()});
  for (MapObject& object : m.objects) m.Move(object, input, occlusion);
  report.timings.push_back({"move", watch.Lap()});
  m.mean_maps =
      m.renderer->Render(m.setup.camera, input.world_from_cam.inverse(), m.MeanStates(false));
  const std::span<const Detection> detections =
      input.detections ? input.detections->proposals() : std::span<const Detection>{};
  report.proposals =
      ExplainProposals(detections, m.objects, m.mean_maps, *m.setup.database, m.options());
  m.Associate(report.proposals, input);
  report.timings.push_back({"explain", watch.Lap()});
  m.Spawn(report.proposals, input, occlusion, report);
  report.timings.push_back({"spawn", watch.Lap()});
  m.UpdateLifecycle(input, report);
  if (m.options().key_frames > 0) m.memory.Offer(input);

  for (const MapObject& object : m.objects) report.objects.push_back(ToReport(object));
  report.next_object_id = m.next_object_id;
  report.mapper_state = m.memory.Save();
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
  return m.memory.Restore(report.mapper_state, load, *m.renderer);
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
