// SPDX-License-Identifier: Apache-2.0
#include "engine/mapping/mapper.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

#include "engine/mapping/association.h"
#include "engine/mapping/bytes.h"
#include "engine/mapping/mapper_impl.h"
#include "engine/mapping/outline_lines.h"
#include "engine/vision/category_names.h"

namespace plumbline {
namespace {

constexpr double kFirstFrame_s = 1.0 / 30.0;
constexpr double kLooksBeforeMerging = 1;
constexpr double kLinesOfTable = 1.5;  ///< OutlineLines of a thing with `view_correlation`.
constexpr std::size_t kJoined = 60;    ///< Poses that a merged object leaves, about.
constexpr double kPlanted_m = 0.02, kPlanted_rad = 0.03;  ///< Deviations of what is planted.
/// A confirmed object in doubt that is known to no better than so many times what confirmation
/// asks, in so many independent looks, is lost.
constexpr double kLostSpread = 3, kLostLooks = 3;
constexpr double kSpawnReach = 2.0;  // at half size: four times as far as later

std::string MotionInWords(const MotionTest& motion, const MapperOptions& options) {
  char text[64];
  std::snprintf(text, sizeof(text), "its boxes move, at about %.1f m/s",
                motion.Velocity(options).norm());
  return text;
}

}  // namespace

MapObject Mapper::Impl::NewObject(std::string category, const MapperInput& input) const {
  MapObject object;
  object.id = ObjectId{next_object_id};
  object.category = std::move(category);
  object.reference_frame = object.first_frame = object.last_frame = input.frame;
  object.world_from_reference_cam = input.world_from_cam;
  object.reference_uncertainty = input.pose_uncertainty;
  object.reference_pose = input.pose_id;
  object.reference_epoch = input.pose_epoch;
  return object;
}

std::optional<MapObject> Mapper::Impl::Spawn(const ProposalReport& proposal,
                                             const MapperInput& input,
                                             const OrientedTable& wide_table,
                                             const OcclusionMaps& occluders) {
  MapObject object = NewObject(proposal.category, input);
  object.last_proposal = Detection{proposal.box, proposal.category, proposal.score};
  object.world_from_proposal_cam = input.world_from_cam;
  std::vector<PoseHypothesis> drawn =
      SampleBirth(*object.last_proposal, setup.camera, input.world_from_cam, map, options(),
                  options().spawn_particles, Key(setup.seed, input.frame, object.id, Draw::kBirth));
  if (drawn.empty()) return std::nullopt;
  Populate(object, drawn, input, wide_table, occluders);
  return object;
}

void Mapper::Impl::Populate(MapObject& object, const std::vector<PoseHypothesis>& drawn,
                            const MapperInput& input, const OrientedTable& wide_table,
                            const OcclusionMaps& occluders) {
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
  PoseSampler sampler(map, options(),
                      Beside(object, Posterior(*setup.scorer, map, {}, wide, exact)),
                      Key(setup.seed, input.frame, object.id, Draw::kSample));
  Population population =
      sampler.Temper(drawn, static_cast<std::size_t>(options().tentative_particles));
  for (Judgement& judged : population.judged) judged.memory = 0;
  Take(object, population);
  object.effective_sample_size = EffectiveSampleSize(object.particles);
  object.Summarize(map);
  object.updated = true;
  object.log_evidence = TentativeLogOdds({}, options());
}

void Mapper::Impl::SpawnPlanted(const MapperInput& input, const OcclusionMaps& occluders,
                                FrameReport& report) {
  for (const Planted& seed : std::exchange(planted, {})) {
    MapObject object = NewObject(setup.database->model(seed.pose.label).category, input);
    const PoseHypothesis middle = ToHypothesis(seed.pose, map);
    RandomKey key = Key(setup.seed, input.frame, object.id, Draw::kBirth);
    std::vector<PoseHypothesis> drawn;
    for (; static_cast<int>(drawn.size()) < options().spawn_particles; ++key.particle) {
      Random random(key);
      drawn.push_back(middle);
      for (int axis = 0; axis < 3; ++axis)
        drawn.back().center_in_world[axis] += kPlanted_m * random.Gaussian();
      drawn.back().azimuth_rad = WrapAngle(middle.azimuth_rad + kPlanted_rad * random.Gaussian());
    }
    const auto wide_table =
        SearchTable(HalfSize(input.edges), options(), setup.camera.fx, kSpawnReach);
    Populate(object, drawn, input, *wide_table, occluders);
    ++next_object_id;
    report.events.push_back({EventKind::kSpawned, object.id, {}, seed.why});
    objects.push_back(std::move(object));
  }
}

void Mapper::Impl::Spawn(std::vector<ProposalReport>& proposals, const MapperInput& input,
                         const OcclusionMaps& occluders, FrameReport& report) {
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
    if (!wide_table)
      wide_table = SearchTable(HalfSize(input.edges), options(), setup.camera.fx, kSpawnReach);
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

const MapperOptions& Mapper::Impl::OptionsFor(ModelId label) const {
  const auto known = options_for.find(label.value);
  if (known != options_for.end()) return known->second;
  MapperOptions result = options();
  result.view_correlation *= kLinesOfTable / OutlineLines(*setup.scorer, *setup.database, label);
  return options_for.emplace(label.value, result).first->second;
}

bool Mapper::Impl::IsPlaced(const MapObject& object) const {
  return IsKnown(object, options().confirm_mode_weight);
}

bool Mapper::Impl::MayBeConfirmed(const MapObject& object) const {
  const std::optional<double> least =
      BeliefToConfirm(object.shown, object.visible_fraction, HasRivalMode(object), options());
  return least && IsKnown(object, *least);
}

bool Mapper::Impl::IsKnown(const MapObject& object, double least_belief) const {
  if (options().filter == FilterKind::kPaper) return false;
  const bool may_move = MovesByItself(object.category);
  return object.log_evidence > options().confirm_evidence &&
         // Its boxes of before it was spawned count.
         (object.seen_s > options().confirm_age_s ||
          (may_move && object.motion.boxes() >= MotionTest::kLeastBoxes)) &&
         object.mean().position_std_m < map.LeastKnown(object.mean().label, options()) &&
         (!may_move ||
          object.motion.LogStanding(options()) >= std::log(options().confirm_standing)) &&
         BeliefInMean(object) >= least_belief;
}

double Mapper::Impl::SpreadOfModes(const MapObject& object) const {
  double weight = 0, squares = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const PoseMode& mode : object.modes) {
    const Eigen::Vector3d center = ToHypothesis(mode, map).center_in_world;
    weight += mode.weight;
    sum += mode.weight * center;
    squares += mode.weight * (center.squaredNorm() + mode.position_std_m * mode.position_std_m);
  }
  if (weight <= 0) return 0;
  return std::sqrt(std::max(0.0, squares / weight - (sum / weight).squaredNorm()));
}

void Mapper::Impl::CountLook(MapObject& object, const Sighting& sighting, double novelty) const {
  // One frame may tip the belief in one of two poses; a whole look at enough of it decides.
  const bool in_doubt = BeliefInMean(object) < kInDoubt;
  if (in_doubt && object.state == ObjectState::kConfirmed && !MovesByItself(object.category) &&
      SpreadOfModes(object) > kLostSpread * map.LeastKnown(object.mean().label, options())) {
    object.shown = std::min(0.0, object.shown) - novelty * (1 - object.hidden);
  } else if (in_doubt) {
    object.shown = 0;
  } else {
    object.shown = std::max(0.0, object.shown);
    if (ShowsEnough(sighting, object.visible_fraction)) object.shown += novelty;
  }
}

void Mapper::Impl::UpdateLifecycle(const MapperInput& input, double novelty, FrameReport& report) {
  for (MapObject& object : objects) {
    if (object.state == ObjectState::kTentative && !object.updated &&
        (ToHypothesis(object.mean(), map).center_in_world - input.world_from_cam.translation())
                .norm() > options().left_behind_m)
      Retire(object, EventKind::kRetired, {}, "tentative and left behind", report);
    if (object.state == ObjectState::kRetired || !object.updated) continue;
    const double least = object.state == ObjectState::kTentative ? options().dismiss_evidence
                                                                 : options().retire_evidence;
    const bool may_move = MovesByItself(object.category);
    // What passes fast shows from a new side in every image: its pose needs some searches first.
    const bool judged = !may_move || object.state == ObjectState::kConfirmed ||
                        object.seen_s > options().confirm_age_s;
    if (object.log_evidence < least && judged) {
      Retire(object, EventKind::kRetired, {}, "seen where it should show, without support", report);
    } else if (object.shown <= -kLostLooks) {
      Retire(object, EventKind::kRetired, {}, "in view, and no longer known where it stands",
             report);
    } else if (may_move && BeliefInMean(object) >= kInDoubt &&
               std::max(object.log_evidence, judged ? least : 0.0) +
                       object.motion.LogAgainst(options()) <
                   least) {
      Retire(object, EventKind::kRetired, {}, MotionInWords(object.motion, options()), report);
    } else if (object.state == ObjectState::kTentative && MayBeConfirmed(object)) {
      object.state = ObjectState::kConfirmed;
      object.confirmed_frame = input.frame;
      report.events.push_back({EventKind::kConfirmed, object.id, {}, "evidence has accumulated"});
    } else if (object.state == ObjectState::kTentative &&
               object.seen_s > options().tentative_limit_s && !IsPlaced(object)) {
      Retire(object, EventKind::kRetired, {}, "tentative for too long", report);
    }
  }
  MergeDuplicates(novelty, report);
}

void Mapper::Impl::MergeDuplicates(double novelty, FrameReport& report) {
  const auto settled = [&](const MapObject& object) {
    return object.state == ObjectState::kConfirmed ||
           (object.state == ObjectState::kTentative &&
            object.seen_s > options().tentative_search_s);
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
    // Of two that are confirmed the one in view: the other's poses are weighed in its next search.
    const auto rank = [](const MapObject& object) {
      const bool confirmed = object.state == ObjectState::kConfirmed;
      return std::make_tuple(confirmed, confirmed && object.updated, object.log_evidence,
                             -object.id.value);
    };
    MapObject& winner = rank(a) > rank(*rival) ? a : *rival;
    MapObject& loser = rank(a) > rank(*rival) ? *rival : a;
    // The loser's poses go on as the winner's: its next search weighs them by all that it has seen.
    for (std::size_t k = 0; k < loser.particles.size(); k += loser.particles.size() / kJoined + 1)
      winner.joined.push_back(ToHypothesis(loser.particles[k], loser.world_from_reference_cam));
    Retire(loser, EventKind::kMerged, winner.id,
           "object " + std::to_string(winner.id.value) + " stands there and " +
               (winner.log_evidence < loser.log_evidence ? "is in view" : "has more evidence"),
           report);
  }
}

void Mapper::Impl::KeepFrame(const MapperInput& input) {
  if (options().key_frames == 0) return;
  // What a settled object was judged by stays: it may not be seen again for long.
  std::set<int> needed;
  for (const MapObject& object : objects) {
    if (object.state != ObjectState::kConfirmed) continue;
    for (const ObjectView& view : object.views) needed.insert(view.frame);
  }
  const KeyFrameMemory::Offered offered = memory.Offer(input, needed);
  if (offered.kept) {
    for (MapObject& object : objects) {
      if (object.state == ObjectState::kRetired || !object.updated ||
          object.last_frame != input.frame || object.visible_fraction < kMinViewVisibility ||
          object.present_weight <= 0 ||  // what was spawned just now has not been judged by it
          object.hidden > 0.5) {         // it would stand for views that do show it
        continue;
      }
      for (std::size_t i = 0; i < object.particles.size(); ++i) {
        const Particle& particle = object.particles[i];
        const double detector = DetectorWeightOf(object, ModelId{particle.label});
        object.memory[i] +=
            static_cast<float>(object.present_weight *
                               (detector * particle.phi_cnn + options().beta * particle.phi_edge));
      }
      Remember(object, input.frame, object.present_weight);
      object.present_weight = 0;
    }
  }
  for (const int frame : offered.forgotten) {
    for (MapObject& object : objects) Forget(object, frame);
  }
}

FrameReport Mapper::Impl::Finished(FrameReport report) const {
  for (const MapObject& object : objects) report.objects.push_back(ToReport(object));
  report.next_object_id = next_object_id;
  ByteWriter state;
  clock.Save(state);
  edge_level.Save(state);
  sharpness.Save(state);
  report.mapper_state = state.Take() + memory.Save();
  return report;
}

MapFrame MapFrameOf(const MapperSetup& setup) {
  std::vector<Eigen::AlignedBox2d> feet;
  for (const CadModel& model : setup.database->models()) feet.push_back(FootOf(model));
  return {UprightFrame(setup.gravity_in_world),
          setup.floor_in_world,
          setup.database,
          {},
          setup.floor_std_m,
          {},
          setup.floor_levels,
          setup.options.room_thing_m,
          std::move(feet)};
}

Mapper::Mapper(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Mapper::~Mapper() = default;

Result<std::unique_ptr<Mapper>> Mapper::Create(const MapperSetup& setup) {
  PLB_CHECK(setup.database != nullptr && setup.scorer != nullptr);
  if (setup.database->models().empty()) {
    return Error{ErrorCode::kInvalidInput,
                 "the model folder '" + setup.database->folder().string() + "' has no models"};
  }
  return std::unique_ptr<Mapper>(new Mapper(std::make_unique<Impl>(setup)));
}

FrameReport Mapper::Step(const MapperInput& given) {
  Impl& m = *impl_;
  const MapperInput input = m.Timed(given);
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
  if (m.options().filter == FilterKind::kPaper) {
    m.StepAsPaper(input, dt_s, report);
    return m.Finished(std::move(report));
  }

  StageClock stages(m.boxes_ms, report);
  const std::vector<PlacedModel> occluders = m.MeanStates(true);
  const OcclusionMaps occlusion =
      m.renderer.RenderOccluders(m.setup.camera, input.world_from_cam.inverse(), occluders);
  m.memory.UpdateOcclusion(m.renderer, occluders);
  m.map.supports = m.FindSupports();
  stages.End("visibility");
  for (MapObject& object : m.objects)
    m.UpdateWeights(object, input, occlusion, dt_s, novelty, report);
  stages.End("update");
  for (MapObject& object : m.objects) m.Search(object, input, occlusion);
  stages.End("search");
  m.mean_maps =
      m.renderer.Render(m.setup.camera, input.world_from_cam.inverse(), m.MeanStates(false));
  const std::span<const Detection> detections =
      input.detections ? input.detections->proposals() : std::span<const Detection>{};
  const std::vector<std::optional<std::size_t>> matched =
      MatchProposals(detections, m.objects, m.mean_maps);
  report.proposals =
      ExplainProposals(detections, m.objects, matched, m.mean_maps, *m.setup.database, m.options());
  for (std::size_t i = 0; i < m.objects.size(); ++i) {
    MapObject& object = m.objects[i];
    const Detection* detection = matched[i] ? &detections[*matched[i]] : nullptr;
    if (detection != nullptr) {
      object.last_proposal = *detection;
      object.world_from_proposal_cam = input.world_from_cam;
    }
    if (object.updated) m.UpdateExistence(object, input, occlusion, detection, dt_s, novelty);
  }
  stages.End("explain");
  m.SpawnPlanted(input, occlusion, report);
  m.Spawn(report.proposals, input, occlusion, report);
  stages.End("spawn");
  stages.EndFrame();
  m.UpdateLifecycle(input, novelty, report);
  m.KeepFrame(input);
  m.FindLandmarks(input, report);
  return m.Finished(std::move(report));
}

Status Mapper::Restore(const FrameReport& report,
                       const std::function<Result<MapperInput>(int)>& load) {
  Impl& m = *impl_;
  m.objects.clear();
  m.map.points_in_world.clear();
  m.seen_points.clear();
  if (report.mapper_state.empty()) return {};  // every frame so far was skipped
  for (const ObjectReport& object : report.objects) {
    Result<MapObject> restored = FromReport(object, *m.setup.database);
    if (!restored.ok()) return restored.error();
    m.objects.push_back(std::move(restored).value());
  }
  m.next_object_id = report.next_object_id;
  m.last_stamp_ns = report.stamp_ns;
  ByteReader state(report.mapper_state);
  m.clock.Restore(state);
  m.edge_level.Restore(state);
  m.sharpness.Restore(state);
  const auto load_timed = [&](int frame) -> Result<MapperInput> {
    Result<MapperInput> input = load(frame);
    if (!input.ok()) return input;
    return m.Timed(std::move(input).value());
  };
  return m.memory.Restore(state.rest(), load_timed, m.renderer);
}

void Mapper::SetFloor(const Eigen::Vector4d& floor_in_world, double std_m) {
  impl_->map.floor_in_world = floor_in_world;
  impl_->map.floor_std_m = std_m;
}

void Mapper::AddPoints(const PoseEstimate& seen_from,
                       std::span<const Eigen::Vector3f> points_in_world) {
  auto& points = impl_->map.points_in_world;
  points.insert(points.end(), points_in_world.begin(), points_in_world.end());
  impl_->seen_points.push_back({seen_from, points_in_world.size()});
}

void Mapper::Correct(const PoseEstimate& pose) {
  Impl& m = *impl_;
  m.memory.Correct(pose);
  for (MapObject& object : m.objects) {
    if (object.reference_pose == pose.id && object.reference_epoch < pose.epoch)
      object.MoveTo(pose, m.map);
  }
  std::size_t begin = 0;
  for (Impl::SeenPoints& seen : m.seen_points) {
    const std::size_t end = begin + seen.count;
    if (seen.seen_from.id == pose.id && seen.seen_from.epoch < pose.epoch) {
      const Eigen::Isometry3d move = pose.world_from_cam * seen.seen_from.world_from_cam.inverse();
      for (std::size_t i = begin; i < end; ++i) {
        Eigen::Vector3f& point = m.map.points_in_world[i];
        point = (move * Eigen::Vector3d(point.cast<double>())).cast<float>();
      }
      seen.seen_from = pose;
    }
    begin = end;
  }
}

void Mapper::Plant(ModelId label, const Eigen::Isometry3d& world_from_object, double scale,
                   const std::string& why) {
  PoseMode pose;
  pose.label = label;
  pose.world_from_object = world_from_object;
  pose.scale = scale;
  impl_->planted.push_back({pose, why});
}

void Mapper::SetOptions(const MapperOptions& options) {
  impl_->setup.options = options;
  impl_->map.room_thing_m = options.room_thing_m;
  impl_->memory.SetOptions(options);
}

const RenderedMaps& Mapper::mean_maps() const { return impl_->mean_maps; }

RenderedMaps Mapper::RenderMeans(const FrameReport& report) {
  if (!report.world_from_cam) return {};
  std::vector<PlacedModel> placed;
  for (const ObjectReport& object : report.objects) {
    if (object.state != ObjectState::kRetired)
      placed.push_back({object.id, object.label, object.world_from_object, object.scale});
  }
  return impl_->renderer.Render(impl_->setup.camera, report.world_from_cam->inverse(), placed);
}

}  // namespace plumbline
