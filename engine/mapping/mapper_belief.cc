// SPDX-License-Identifier: Apache-2.0
// What a frame does to the belief about one object.
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/mapping/mapper_impl.h"
#include "engine/mapping/outline_error.h"
#include "engine/vision/category_names.h"

namespace plumbline {
namespace {

/// Modes within this (times LengthScale) are one pose, whatever their shapes.
constexpr double kSamePose_m = 0.15, kSamePose_rad = 30 * kRadPerDeg;
/// Particles that fit better than the mean count for what they expect by exp(this * Phi_edge).
constexpr double kMarginalSharpness = 5;
/// Of what settled objects show, a smaller share tells nothing of the level of the edges.
constexpr double kLeastTelling = 0.1;
/// The time between searches is the time in view over this, between the options' limits.
constexpr double kSearchRelaxation = 8.0;
/// Of the height of a surface, the base of what may stand on it.
constexpr double kStandsWithin_m = 0.1;
/// Overlap of a box of a past image with an object's visible box that makes it the object's.
constexpr float kRememberedIou = 0.3f;
/// How much sharper from one frame to the next the views of a settled object are taken: particles
/// have to follow.
constexpr double kSharpening = 1.2;
/// Views of an object that settle its pose, so that another tells how far views are off.
constexpr double kSettlingViews = 3;
constexpr std::size_t kOutlineSample = 128;  ///< Particles that tell how a belief follows outlines.
constexpr std::size_t kChallengerCount = 160;  ///< Besides newcomers.
constexpr int kNewcomerCount = 100;
constexpr double kManyJumped =
    0.3;  ///< Share of accepted jumps that makes a second round worth it.

/// How far apart two views of what is driven up to are: it shows anew as its distance halves, not
/// with every metre.
double SharesApart(const KeyFrame& a, const KeyFrame& b, const Eigen::Vector3d& center_in_world) {
  const Eigen::Vector3d from_a = a.input.world_from_cam.translation(),
                        from_b = b.input.world_from_cam.translation();
  const double near_m =
      std::min((from_a - center_in_world).norm(), (from_b - center_in_world).norm());
  return (from_a - from_b).norm() / std::max(1e-3, near_m);
}

}  // namespace

void Mapper::Impl::UpdateWeights(MapObject& object, const MapperInput& input,
                                 const OcclusionMaps& occluders, double dt_s, double novelty,
                                 FrameReport& report) {
  const ScoringView view = ViewOf(object, input, occluders);
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
      Evaluate(*setup.scorer, now.view.view, map, input.detections.get(), hypotheses,
               now.view.normalizer, options());
  // The present frame takes the place of the last one: together with the remembered views it is
  // worth what its viewpoint adds to them. Without memory, frames count for what each adds.
  double weight = remembers ? 1.0 : novelty;
  for (const ObjectView& seen : object.views) {
    if (const KeyFrame* key = memory.Find(seen.frame)) {
      weight = std::min(weight, memory.Distance(key->input.world_from_cam, input.world_from_cam));
    }
  }
  const std::vector<double> last = LogLikelihoods(object);
  if (remembers) LookAtCrop(object, input, view);
  // What an unmapped thing hides shows edges of that thing.
  object.present_weight = weight * now.telling * (1 - object.hidden);
  // Where views are sharper than stated, the search for one pose needs it too; but of twins they
  // are not as sure as of a pixel.
  const double measured = object.slopes.ValueWithin(sharpness);
  object.sharpness = std::min(object.state == ObjectState::kConfirmed
                                  ? measured
                                  : std::clamp(measured, 1.0, options().tentative_sharpness),
                              kSharpening * object.sharpness);
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
      Population population = Rejudge(object, LogLikelihoods(object), wanted, sampler, input.frame);
      sampler.Walk(population);
      Take(object, population);
    } else {
      object.particles = SystematicResample(
          object.particles, wanted, Key(setup.seed, input.frame, object.id, Draw::kResample));
      object.memory.assign(object.particles.size(), 0.0f);
    }
  }
  Summarize(object, input);

  const Likelihood after = AtMean(object, view, input.detections.get());
  object.phi_cnn = after.phi_cnn;
  object.phi_edge = AtMean(object, now.view.view, nullptr).phi_edge;
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

Sighting Mapper::Impl::SightingOf(const PoseHypothesis& pose, double visible_fraction,
                                  const Box2& visible_box, const MapperInput& input,
                                  const Judging& own_edges) const {
  const double focal = kFocalOfOptions_px / setup.camera.fx;
  Sighting sighting;
  const double open = map.points_in_world.empty() ? 1 : 1 - Screened(pose, visible_box, input);
  sighting.visible_px = open * visible_box.area() * focal * focal;
  sighting.visible_fraction = open * visible_fraction;
  sighting.telling = own_edges.telling;
  sighting.edge_fraction = open * own_edges.visible_fraction;
  sighting.inside_fraction = InsideFraction(setup.database->model(pose.label), pose, map,
                                            setup.camera, input.world_from_cam.inverse());
  return sighting;
}

double Mapper::Impl::Screened(const PoseHypothesis& pose, const Box2& visible_box,
                              const MapperInput& input) const {
  const Eigen::Isometry3d cam_from_world = input.world_from_cam.inverse();
  const Eigen::Isometry3d cam_from_object = cam_from_world * map.WorldFromObject(pose);
  const Eigen::AlignedBox3d bounds = Scaled(setup.database->model(pose.label).bounds, pose.scale());
  double front = std::numeric_limits<double>::max();
  for (int corner = 0; corner < 8; ++corner) {
    const auto at = static_cast<Eigen::AlignedBox3d::CornerType>(corner);
    front = std::min(front, (cam_from_object * bounds.corner(at)).z());
  }
  return ScreenedShare(visible_box, front, map.points_in_world, setup.camera, cam_from_world,
                       *setup.database, MeanStates(true));
}

Mapper::Impl::RememberedLooks Mapper::Impl::LookBack(const MapObject& object,
                                                     const MapperInput& input,
                                                     const OcclusionMaps& occluders) const {
  RememberedLooks looks;
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  const double looks_per_view = options().key_frame_distance_m / options().correlation_m;
  const auto add = [&](const MapperInput& from, const OcclusionMaps& maps, double weight) {
    const Judging judging = Judge(object, from, maps);
    if (judging.telling <= 0) return;
    const ScoringView& view = judging.view.view;
    const Likelihood shown = AtMean(object, view, nullptr);
    const Judging own = JudgeByOwnEdges(object, from, maps);
    Sighting sighting = SightingOf(mean, shown.visible_fraction, shown.visible_box, from, own);
    if (from.detections) {
      for (const Detection& box : from.detections->proposals()) {
        const float iou = Iou(box.box, shown.visible_box);
        if (box.category != object.category || iou < kRememberedIou ||
            box.score * iou < sighting.box_score * sighting.box_iou)
          continue;
        sighting.box_score = box.score;
        sighting.box_iou = iou;
      }
    }
    sighting.edge_surplus =
        static_cast<float>(EdgeSurplus(*setup.scorer, own.view.view, map, mean) *
                           EdgeLevel::kUsual / EdgeLevelOf(object, own));
    const double views = weight / judging.telling;
    looks.evidence += views * looks_per_view * SightingLogRatio(sighting, options());
    looks.boxes += views * looks_per_view * BoxLogRatio(sighting, options());
    if (ShowsEnough(sighting, shown.visible_fraction)) looks.shown += views;
  };
  add(input, occluders, object.present_weight);
  for (const ObjectView& seen : object.views) {
    if (const KeyFrame* key = memory.Find(seen.frame)) add(key->input, key->maps, seen.weight);
  }
  return looks;
}

void Mapper::Impl::UpdateExistence(MapObject& object, const MapperInput& input,
                                   const OcclusionMaps& occluders, const Detection* matched,
                                   double dt_s, double novelty) {
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  const Judging own = JudgeByOwnEdges(object, input, occluders);
  // What all particles together expect of this image, not the mean alone: it may be between modes.
  double expected = 0;
  for (const Particle& particle : object.particles)
    expected += std::exp(particle.log_weight + kMarginalSharpness * particle.phi_edge);
  const double marginal = std::log(expected) / kMarginalSharpness;
  Sighting sighting = SightingOf(mean, object.visible_fraction, object.visible_box, input, own);
  sighting.novelty = novelty;
  if (matched != nullptr) {
    sighting.box_score = matched->score;
    sighting.box_iou = Iou(matched->box, object.visible_box);
  }
  const double surplus = EdgeSurplus(*setup.scorer, own.view.view, map, mean) +
                         std::max(0.0, marginal - object.phi_edge);
  // Strong edges give more to everything, right or wrong: what settled objects get is the measure.
  sighting.edge_surplus =
      static_cast<float>(surplus * EdgeLevel::kUsual / EdgeLevelOf(object, own));
  if (object.state == ObjectState::kConfirmed && object.log_evidence > kSettledLogOdds &&
      object.visible_fraction >= options().confirm_shown) {
    const double at_full_size =
        own.large ? surplus / std::max(kLeastTelling, own.telling) : surplus;
    edge_level.Add(object.category, at_full_size, novelty);
    if (object.remembered() >= kSettlingViews) {
      const JudgingView view = Judge(object, input, occluders).view;
      const ViewSlope slope = SlopeOf(*setup.scorer, view, map, mean, options());
      sharpness.Add(slope, novelty);
      object.slopes.Add(slope, novelty);
    }
  }
  CountLook(object, sighting, novelty);
  if (MovesByItself(object.category)) Follow(object, matched, input);
  // Only what has been seen to be there can be said to be hidden.
  if (object.state == ObjectState::kConfirmed) {
    Existence existence{object.log_evidence, object.hidden};
    existence.Update(sighting, dt_s, options());
    object.log_evidence = existence.log_odds;
    object.hidden = existence.hidden;
  } else {
    Existence existence{object.passing, 0};
    existence.UpdateInView(sighting, options());
    object.passing = existence.log_odds;
    object.log_evidence = TentativeLogOdds(object.evidence(), options());
  }
}

void Mapper::Impl::Summarize(MapObject& object, const MapperInput& input) const {
  std::vector<WeightedView> views = {
      {{input.world_from_cam, input.pose_uncertainty}, object.present_weight}};
  for (const ObjectView& seen : object.views) {
    if (const KeyFrame* key = memory.Find(seen.frame))
      views.push_back({{key->input.world_from_cam, key->input.pose_uncertainty}, seen.weight});
  }
  object.shared_error = SharedError(object.mean().world_from_object.translation(), views,
                                    {object.world_from_reference_cam, object.reference_uncertainty},
                                    options().scale_std);
  object.Summarize(map);
}

ObjectId Mapper::Impl::SupportUnder(const MapObject& object,
                                    const Eigen::Isometry3d& world_from_cam) const {
  if (map.supports.empty() || setup.database->model(object.mean().label).support == Support::kFloor)
    return {};
  const Eigen::Vector3d base = map.BaseInUpright(ToHypothesis(object.mean(), map));
  const double camera_m = map.upright.up_in_world().dot(world_from_cam.translation());
  for (const SupportSurface& surface : map.supports) {
    if (surface.Holds(base.head<2>()) && camera_m > surface.height_m &&
        std::abs(base.z() - surface.height_m) < kStandsWithin_m)
      return surface.object;
  }
  return {};
}

bool Mapper::Impl::IsSamePose(const PoseHypothesis& pose, const PoseHypothesis& mean) const {
  const Eigen::Vector3d offset = pose.center_in_world - mean.center_in_world;
  return offset.norm() < kSamePose_m * map.LengthScale(mean.label) &&
         std::abs(AzimuthDifference(setup.database->model(mean.label), pose.azimuth_rad,
                                    mean.azimuth_rad)) < kSamePose_rad;
}

double Mapper::Impl::BeliefInMean(const MapObject& object) const {
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  double sum = 0;
  for (const PoseMode& mode : object.modes) {
    if (IsSamePose(ToHypothesis(mode, map), mean)) sum += mode.weight;
  }
  return sum;
}

bool Mapper::Impl::HasRivalMode(const MapObject& object) const {
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  return std::any_of(object.modes.begin(), object.modes.end(), [&](const PoseMode& mode) {
    return !IsSamePose(ToHypothesis(mode, map), mean);
  });
}

std::vector<JudgingView> Mapper::Impl::ViewsOf(const MapObject& object, const MapperInput& input,
                                               const OcclusionMaps& occluders) const {
  std::vector<JudgingView> views;
  for (const ObjectView& seen : object.views) {
    const KeyFrame* key = memory.Find(seen.frame);
    if (key == nullptr) continue;
    views.push_back(Judge(object, key->input, key->maps).view);
    views.back().weight = seen.weight;
  }
  views.push_back(Judge(object, input, occluders).view);
  views.back().weight = object.present_weight;
  return views;
}

Eigen::Matrix4d Mapper::Impl::OutlineErrorOf(const MapObject& object, const MapperInput& input,
                                             const OcclusionMaps& occluders) const {
  if (options().outline_std_px <= 0 && options().outline_side_std_px <= 0)
    return Eigen::Matrix4d::Zero();
  const PoseHypothesis mean = ToHypothesis(object.mean(), map);
  const std::size_t stride = std::max<std::size_t>(1, object.particles.size() / kOutlineSample);
  std::vector<PoseHypothesis> sample;
  for (std::size_t i = 0; i < object.particles.size(); i += stride) {
    const PoseHypothesis drawn = ToHypothesis(object.particles[i], object.world_from_reference_cam);
    if (drawn.label == mean.label && IsSamePose(drawn, mean)) sample.push_back(drawn);
  }
  return OutlineCovariance(
      OutlineSensitivity(*setup.scorer, map, ViewsOf(object, input, occluders), sample, mean,
                         OptionsFor(mean.label), object.sharpness),
      options().outline_std_px, options().outline_side_std_px);
}

Target Mapper::Impl::PosteriorOf(const MapObject& object, const MapperInput& input,
                                 const OcclusionMaps& occluders) const {
  std::vector<JudgingView> remembered = ViewsOf(object, input, occluders);
  const JudgingView present = std::move(remembered.back());
  remembered.pop_back();
  Target posterior = Posterior(*setup.scorer, map, std::move(remembered), present,
                               OptionsFor(object.mean().label), object.sharpness);
  return WithCrops(object.crops, options(), Beside(object, std::move(posterior)));
}

std::vector<double> Mapper::Impl::LogLikelihoods(const MapObject& object) const {
  const double scale = ViewScale(object.remembered() + object.present_weight, object.sharpness,
                                 OptionsFor(object.mean().label));
  std::vector<double> result;
  for (std::size_t i = 0; i < object.particles.size(); ++i) {
    const Particle& particle = object.particles[i];
    const double detector = DetectorWeightOf(object, ModelId{particle.label});
    result.push_back(
        scale * (object.memory[i] + object.present_weight * (detector * particle.phi_cnn +
                                                             options().beta * particle.phi_edge)) +
        LogCrops(object.crops, ModelId{particle.label}, particle.azimuth, options()));
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
  for (const Particle& particle : SystematicResample(
           object.particles, count, Key(setup.seed, frame, object.id, Draw::kResample))) {
    population.hypotheses.push_back(hypotheses[particle.ancestor]);
    population.judged.push_back(judged[particle.ancestor]);
    population.ancestors.push_back(particle.ancestor);
  }
  return population;
}

void Mapper::Impl::Take(MapObject& object, const Population& population) {
  object.particles = ToParticles(population.hypotheses, object.world_from_reference_cam);
  object.memory.clear();
  for (std::size_t i = 0; i < population.size(); ++i) {
    object.particles[i].phi_cnn = population.judged[i].phi_cnn;
    object.particles[i].phi_edge = population.judged[i].phi_edge;
    if (!population.ancestors.empty()) object.particles[i].ancestor = population.ancestors[i];
    object.memory.push_back(population.judged[i].memory);
  }
}

std::vector<const KeyFrame*> Mapper::Impl::ChooseViews(const MapObject& object) const {
  std::vector<const KeyFrame*> rest, chosen;
  for (const KeyFrame& key : memory.frames()) {
    if (Judge(object, key.input, key.maps).visible_fraction >= kMinViewVisibility)
      rest.insert(rest.begin(), &key);  // from the newest back
  }
  const Eigen::Vector3d center = ToHypothesis(object.mean(), map).center_in_world;
  const bool large = map.LengthScale(object.mean().label) > 1;
  const auto apart = [&](const KeyFrame& a, const KeyFrame& b) {
    return large ? SharesApart(a, b, center)
                 : (a.input.world_from_cam.translation() - b.input.world_from_cam.translation())
                       .norm();
  };
  while (!rest.empty() && static_cast<int>(chosen.size()) < options().views_per_object) {
    std::size_t pick = 0;
    double furthest = -1;
    for (std::size_t i = 0; i < rest.size(); ++i) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const KeyFrame* other : chosen) {
        nearest = std::min(nearest, apart(*rest[i], *other));
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
  // Of the two views that are closest to each other the older goes; the other stands for it. So the
  // last view of what is driven past would come to stand for all, and it would be known by the
  // image that it leaves: of large things those two are joined by which least is lost (Ward, 1963),
  // and the heavier stays.
  const Eigen::Vector3d center = ToHypothesis(object.mean(), map).center_in_world;
  const bool large = map.LengthScale(object.mean().label) > 1;
  const auto loss = [&](const ObjectView& a, const ObjectView& b) {
    const KeyFrame *key_a = memory.Find(a.frame), *key_b = memory.Find(b.frame);
    if (key_a == nullptr || key_b == nullptr) return 0.0;
    if (!large) return memory.Distance(key_a->input.world_from_cam, key_b->input.world_from_cam);
    const double apart = SharesApart(*key_a, *key_b, center);
    return a.weight * b.weight / std::max(1e-6, a.weight + b.weight) * apart * apart;
  };
  std::size_t drop = 0, heir = 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < object.views.size(); ++i) {
    for (std::size_t j = i + 1; j < object.views.size(); ++j) {
      const double lost = loss(object.views[i], object.views[j]);
      if (lost >= least) continue;
      least = lost;
      drop = i;
      heir = j;
      if (large && object.views[i].weight > object.views[j].weight) std::swap(drop, heir);
    }
  }
  object.views[heir].weight += object.views[drop].weight;
  object.views.erase(object.views.begin() + static_cast<std::ptrdiff_t>(drop));
}

void Mapper::Impl::Forget(MapObject& object, int frame) {
  const auto forgotten = std::find_if(object.views.begin(), object.views.end(),
                                      [&](const ObjectView& view) { return view.frame == frame; });
  if (forgotten == object.views.end()) return;
  const double weight = forgotten->weight;
  object.views.erase(forgotten);
  const auto heir = std::min_element(object.views.begin(), object.views.end(),
                                     [&](const ObjectView& a, const ObjectView& b) {
                                       return std::abs(a.frame - frame) < std::abs(b.frame - frame);
                                     });
  if (heir != object.views.end()) heir->weight += weight;
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
  Target posterior = PosteriorOf(object, input, occluders);
  PoseSampler sampler(map, options(), posterior,
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
  Summarize(object, input);
  if (!tentative || IsPlaced(object)) {
    object.outline_covariance = OutlineErrorOf(object, input, occluders);
    Summarize(object, input);
  }
  if (!tentative) {
    CompareShapes(object, population, std::move(posterior), input.frame);
    return;
  }
  const RememberedLooks looks = LookBack(object, input, occluders);
  object.remembered_evidence = looks.evidence;
  object.remembered_boxes = looks.boxes;
  // What passes has shown best before it is known where it stands.
  if (map.LengthScale(object.mean().label) > 1 && BeliefInMean(object) >= kInDoubt)
    object.shown = std::max(object.shown, looks.shown);
}

}  // namespace plumbline
