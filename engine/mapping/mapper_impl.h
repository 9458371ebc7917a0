// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the mapper's sources share; nobody else includes it.

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/timer.h"
#include "engine/mapping/birth.h"
#include "engine/mapping/cross_sections.h"
#include "engine/mapping/edge_level.h"
#include "engine/mapping/existence.h"
#include "engine/mapping/judging.h"
#include "engine/mapping/likelihood_sharpness.h"
#include "engine/mapping/map_object.h"
#include "engine/mapping/mapper.h"
#include "engine/mapping/novelty_clock.h"
#include "engine/mapping/pose_error.h"
#include "engine/mapping/sparse_points.h"
#include "engine/vision/detector.h"

namespace plumbline {

inline constexpr double kMinViewVisibility = 0.15;  ///< Of a contour, in a view worth remembering.
/// Log odds that it is there, above which an object is settled.
inline constexpr double kSettledLogOdds = 4;
/// Belief in the mean pose below which a look at the object has decided nothing.
inline constexpr double kInDoubt = 0.8;
inline constexpr double kFocalOfOptions_px = 500;  ///< Areas in pixels are of such a camera.

/// What a random draw is for: each has numbers of its own.
enum class Draw : std::uint32_t {
  kDiffuse,
  kResample,
  kSample,
  kBirth,
  kNewcomers,
  kSearch,
  kLandmark,
  kShapes
};

inline RandomKey Key(std::uint64_t seed, int frame, ObjectId object, Draw draw) {
  return {seed, static_cast<std::uint32_t>(frame),
          static_cast<std::uint32_t>(object.value) * 8 + static_cast<std::uint32_t>(draw), 0};
}

inline std::vector<PoseHypothesis> ToHypotheses(const std::vector<Particle>& particles,
                                                const Eigen::Isometry3d& world_from_reference_cam) {
  std::vector<PoseHypothesis> hypotheses;
  hypotheses.reserve(particles.size());
  for (const Particle& particle : particles)
    hypotheses.push_back(ToHypothesis(particle, world_from_reference_cam));
  return hypotheses;
}

inline std::vector<Particle> ToParticles(const std::vector<PoseHypothesis>& hypotheses,
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

/// Adds what top-down scores take to a sum that outlives it.
class TimedDetections : public FrameDetections {
 public:
  TimedDetections(std::shared_ptr<const FrameDetections> detections, double* milliseconds)
      : detections_(std::move(detections)), milliseconds_(milliseconds) {}
  std::span<const Detection> proposals() const override { return detections_->proposals(); }
  void ScoreBoxes(std::string_view category, std::span<const Box2> boxes,
                  std::span<float> scores) const override {
    const Stopwatch watch;
    detections_->ScoreBoxes(category, boxes, scores);
    *milliseconds_ += watch.Milliseconds();
  }

 private:
  std::shared_ptr<const FrameDetections> detections_;
  double* milliseconds_;
};

/// Writes down what the stages of a frame take. Top-down scores, which all of them ask for, are a
/// stage of their own.
class StageClock {
 public:
  StageClock(double& boxes_ms, FrameReport& report) : boxes_ms_(boxes_ms), report_(report) {
    boxes_ms_ = 0;
  }
  void End(const char* stage) {
    report_.timings.push_back({stage, watch_.Lap() - (boxes_ms_ - counted_ms_)});
    counted_ms_ = boxes_ms_;
  }
  void EndFrame() { report_.timings.insert(report_.timings.begin(), {"score boxes", counted_ms_}); }

 private:
  double& boxes_ms_;
  double counted_ms_ = 0;
  FrameReport& report_;
  Stopwatch watch_;
};

struct Mapper::Impl {
  MapperSetup setup;
  MapFrame map;
  OcclusionRenderer renderer;
  KeyFrameMemory memory;
  std::vector<MapObject> objects;
  std::int32_t next_object_id = 1;
  std::optional<std::int64_t> last_stamp_ns;
  NoveltyClock clock;
  EdgeLevel edge_level;                                       ///< Of this sequence.
  LikelihoodSharpness sharpness;                              ///< Of the views of this sequence.
  mutable std::map<std::int32_t, MapperOptions> options_for;  ///< By label, see OptionsFor.
  /// Some of `map.points_in_world`, in their order.
  struct SeenPoints {
    PoseEstimate seen_from;
    std::size_t count = 0;
  };
  std::vector<SeenPoints> seen_points;
  struct Planted {
    PoseMode pose;
    std::string why;
  };
  std::vector<Planted> planted;  ///< For the next frame.
  RenderedMaps mean_maps;
  std::vector<std::optional<double>> support_heights;  ///< Of each model, see SupportHeight.
  std::vector<CrossSections> sections;                 ///< Of each model.
  double boxes_ms = 0;                                 ///< What top-down scores took in this frame.

  explicit Impl(const MapperSetup& s)
      : setup(s), map(MapFrameOf(s)), renderer(*s.database), memory(s.camera, s.options) {
    for (const CadModel& model : s.database->models()) {
      support_heights.push_back(SupportHeight(model));
      sections.emplace_back(model);
    }
  }

  const MapperOptions& options() const { return setup.options; }

  /// As views of an object of that shape are judged together: `view_correlation` is that of a thing
  /// with as many lines as a table. Does not move.
  const MapperOptions& OptionsFor(ModelId label) const;

  /// The same, but what its top-down scores take is added to `boxes_ms`.
  MapperInput Timed(MapperInput input) {
    if (input.detections != nullptr)
      input.detections = std::make_shared<TimedDetections>(std::move(input.detections), &boxes_ms);
    return input;
  }

  /// @param known_only  Of objects that are confirmed, or placed (IsPlaced).
  std::vector<PlacedModel> MeanStates(bool known_only) const {
    std::vector<PlacedModel> placed;
    for (const MapObject& object : objects) {
      if (known_only && object.state != ObjectState::kConfirmed && !IsPlaced(object)) continue;
      placed.push_back(
          {object.id, object.mean().label, object.mean().world_from_object, object.mean().scale});
    }
    return placed;
  }

  /// @param support  What the object stands on, if that cannot hide it.
  ScoringView View(const MapperInput& input, const OcclusionMaps& occluders, ObjectId object,
                   ObjectId support = {}) const {
    ScoringView view;
    view.camera = setup.camera;
    view.cam_from_world = input.world_from_cam.inverse();
    view.table = input.table.get();
    view.occluder_depth = occluders.DepthBefore(object, support);
    view.occlusion_margin_m = options().occlusion_margin_m;
    view.inner_lines = options().inner_lines;
    return view;
  }

  /// With what the pose of the image may be off by, relative to the object's reference view.
  ScoringView ViewOf(const MapObject& object, const MapperInput& input,
                     const OcclusionMaps& occluders) const {
    ScoringView view =
        View(input, occluders, object.id, SupportUnder(object, input.world_from_cam));
    view.rims = object.state == ObjectState::kConfirmed;
    if (view.rims && IsAfar(map, ToHypothesis(object.mean(), map), view.cam_from_world, options()))
      view.table = &input.narrow_table->Get();
    view.luminance_behind = occluders.LuminanceBehind(object.id);
    view.least_contrast = options().least_contrast;
    view.shifts = ImageShiftsOf(ToHypothesis(object.mean(), map).center_in_world,
                                {input.world_from_cam, input.pose_uncertainty},
                                {object.world_from_reference_cam, object.reference_uncertainty},
                                setup.camera);
    return view;
  }

  Likelihood AtMean(const MapObject& object, const ScoringView& view,
                    const FrameDetections* detections) const {
    const PoseHypothesis mean = ToHypothesis(object.mean(), map);
    return Evaluate(*setup.scorer, view, map, detections, {&mean, 1}, std::nullopt, options())
        .front();
  }

  /// Boxes find what is large while it is far. Once it is settled, a box of what passes before it
  /// must not draw it along.
  double DetectorWeightOf(const MapObject& object, ModelId label) const {
    if (object.state == ObjectState::kConfirmed) return options().alpha;
    const CadModel& model = setup.database->model(label);
    return DetectorWeight(model.category, model.bounds, options());
  }

  /// How an image judges hypotheses of the object, and what it shows of the object's mean.
  struct Judging {
    JudgingView view;
    double visible_fraction = 0;
    double telling = 0;  ///< In [0, 1]: a small or hidden contour says less than a long one.
    bool large = false;  ///< Beyond what rooms hold (MapFrame::LengthScale).
  };
  /// By what its posterior goes. The outline of a screen is its own: or of two cabinets, the one
  /// that reaches up behind the screen would be scored by it.
  Judging Judge(const MapObject& object, const MapperInput& from, const OcclusionMaps& maps) const {
    JudgingView view{ViewOf(object, from, maps), from.detections.get(), 0, 1};
    if (object.state == ObjectState::kConfirmed &&
        setup.database->model(object.mean().label).support == Support::kFloor)
      view.view.occluder_depth = maps.DepthAndContours(object.id, {}, ContoursOf::kRaisedThings);
    return JudgeBy(std::move(view), object);
  }
  /// By its own edges, to tell whether it is there: what settled objects explain speaks for them,
  /// not for another in the same lines.
  Judging JudgeByOwnEdges(const MapObject& object, const MapperInput& from,
                          const OcclusionMaps& maps) const {
    JudgingView view{ViewOf(object, from, maps), from.detections.get(), 0, 1};
    view.view.rims = false;
    view.view.table = from.table.get();
    if (object.state == ObjectState::kTentative)
      view.view.occluder_depth =
          maps.DepthAndContours(object.id, SupportUnder(object, from.world_from_cam));
    return JudgeBy(std::move(view), object);
  }
  Judging JudgeBy(JudgingView view, const MapObject& object) const {
    Judging result{std::move(view), 0, 0};
    if (object.state == ObjectState::kConfirmed) result.view.detector_weight = options().alpha;
    const PoseHypothesis mean = ToHypothesis(object.mean(), map);
    HypothesisScore score;
    setup.scorer->Score(result.view.view, map.upright, {&mean, 1}, {&score, 1});
    result.view.normalizer = EdgeNormalizer({&score, 1});
    result.visible_fraction = score.total_m > 0 ? score.visible_m / score.total_m : 0;
    const double depth = (result.view.view.cam_from_world * mean.center_in_world).z();
    if (depth > 0) {
      const double scale = map.LengthScale(mean.label);
      result.large = scale > 1;
      result.telling = std::min(1.0, score.visible_m * kFocalOfOptions_px / depth /
                                         (scale * options().telling_contour_px));
    }
    return result;
  }

  /// The edge surplus that a right object of that size has here: afar, the search for edges reaches
  /// over a larger part of the thing, and finds edges wherever it looks.
  double EdgeLevelOf(const MapObject& object, const Judging& judging) const {
    const double level = edge_level.Of(object.category);
    return judging.large ? std::max(EdgeLevel::kUsual, level * judging.telling) : level;
  }
  /// Whether a look shows enough of a pose, with support of edges, to be decided by. Where a box
  /// says that this very contour is there, half of that support will do.
  bool ShowsEnough(const Sighting& sighting, double visible_fraction) const {
    const bool boxed = sighting.box_score * sighting.box_iou > options().telling_box;
    return sighting.edge_surplus > options().expected_edge * (boxed ? 0.5 : 1.0) &&
           visible_fraction >= options().confirm_shown;
  }
  /// Deviation of the centre over all modes, not about the mean pose alone [m].
  double SpreadOfModes(const MapObject& object) const;
  /// Adds to what has shown of an object (MapObject::shown), or to the looks in which a confirmed
  /// one was in view and not known to be anywhere.
  void CountLook(MapObject& object, const Sighting& sighting, double novelty) const;
  /// MapObject::Summarize, with what its views share.
  void Summarize(MapObject& object, const MapperInput& input) const;
  /// What confirmed objects on the floor offer to others to stand on.
  std::vector<SupportSurface> FindSupports() const;
  /// The one that an object stands on, if the camera looks down on it: then it hides nothing of the
  /// object, and a pose that sinks into it gains nothing by what would be hidden. Else none.
  ObjectId SupportUnder(const MapObject& object, const Eigen::Isometry3d& world_from_cam) const;
  /// A whole frame of filter = paper (mapper_paper.cc).
  void StepAsPaper(const MapperInput& input, double dt_s, FrameReport& report);
  class PaperStep;

  // Steps of a frame, in order.
  void UpdateWeights(MapObject& object, const MapperInput& input, const OcclusionMaps& occluders,
                     double dt_s, double novelty, FrameReport& report);
  /// What other shapes there may be in the place of a settled object: of a population of its
  /// posterior, and those shapes' masses there, tempered (mapper_shapes.cc).
  void CompareShapes(MapObject& object, const Population& population, Target posterior,
                     int frame) const;
  /// What its crop in this image says of its shape and quarter turn, where it is another view.
  void LookAtCrop(MapObject& object, const MapperInput& input, const ScoringView& view) const;
  /// What an image that shows so much of a pose can say; without novelty, box and edges.
  Sighting SightingOf(const PoseHypothesis& pose, double visible_fraction, const Box2& visible_box,
                      const MapperInput& input, const Judging& own_edges) const;
  /// Share of the visible box of a pose that points of what no model explains stand before.
  double Screened(const PoseHypothesis& pose, const Box2& visible_box,
                  const MapperInput& input) const;
  /// Of the views that the object remembers and of this frame, for its mean pose.
  struct RememberedLooks {
    double evidence = 0, boxes = 0;  ///< As of TentativeEvidence.
    double shown = 0;                ///< In how many views enough of it showed.
  };
  RememberedLooks LookBack(const MapObject& object, const MapperInput& input,
                           const OcclusionMaps& occluders) const;
  void UpdateExistence(MapObject& object, const MapperInput& input, const OcclusionMaps& occluders,
                       const Detection* matched, double dt_s, double novelty);
  /// One more box to tell by whether the object stands still. While it is tentative, and may be
  /// elsewhere than it was thought to be, the boxes of remembered frames are gone through anew.
  void Follow(MapObject& object, const Detection* matched, const MapperInput& input) const;
  /// Where on the ground a box has the object, in level axes; nothing if it does not tell.
  struct PlaceOnGround {
    Eigen::Vector2d place_m;
    Eigen::Matrix2d information;
  };
  std::optional<PlaceOnGround> PlaceBy(const Box2& box, const Box2& expected,
                                       const MapObject& object, const MapperInput& from) const;
  /// The boxes of remembered frames that are of the object, by the box that it has now.
  MotionTest MotionBefore(const MapObject& object, const Box2& now, std::int64_t stamp_ns) const;
  /// Whether a tentative object is there, and where, as far as can be said of what shows of it; it
  /// is confirmed when enough of it has.
  bool IsPlaced(const MapObject& object) const;
  /// The same with another least belief in the mean pose.
  bool IsKnown(const MapObject& object, double least_belief) const;
  /// Whether enough of a tentative object has shown besides (BeliefToConfirm).
  bool MayBeConfirmed(const MapObject& object) const;
  /// Places of objects of its category that the object cannot have: of those that are confirmed,
  /// and, while it is tentative, of those that are placed and have more evidence.
  std::vector<TakenPlace> TakenPlaces(const MapObject& object) const;
  /// Of confirmed objects of other categories.
  std::vector<SupportSurface> TopsOfOthers(const MapObject& object) const;
  /// The target, where other objects are not.
  Target Beside(const MapObject& object, Target target) const;
  /// Views of an object: those it remembers, and the present one as the last.
  std::vector<JudgingView> ViewsOf(const MapObject& object, const MapperInput& input,
                                   const OcclusionMaps& occluders) const;
  /// Covariance of what its views err by alike, as outlines and edges differ.
  Eigen::Matrix4d OutlineErrorOf(const MapObject& object, const MapperInput& input,
                                 const OcclusionMaps& occluders) const;
  /// Its posterior with the views it remembers, and the present frame.
  Target PosteriorOf(const MapObject& object, const MapperInput& input,
                     const OcclusionMaps& occluders) const;
  /// Equally weighted particles, judged anew: what hides the object in past views may be known
  /// better by now.
  Population Rejudge(MapObject& object, const std::vector<double>& last, int count,
                     const PoseSampler& sampler, int frame);
  /// Of the object's particles, as its weights have it.
  std::vector<double> LogLikelihoods(const MapObject& object) const;
  void Take(MapObject& object, const Population& population);
  /// The key frames that show the object from the most different sides, for as many as it
  /// remembers.
  std::vector<const KeyFrame*> ChooseViews(const MapObject& object) const;
  void Remember(MapObject& object, int frame, double weight);
  /// The view nearest in time stands for it from now on.
  void Forget(MapObject& object, int frame);
  void Search(MapObject& object, const MapperInput& input, const OcclusionMaps& occluders);
  /// Settled objects whose place relative to the camera is no longer sure, and where the newest
  /// views have them (mapper_landmarks.cc).
  void FindLandmarks(const MapperInput& input, FrameReport& report) const;
  std::optional<LandmarkSighting> SeenAgain(const MapObject& object,
                                            const MapperInput& input) const;
  void Spawn(std::vector<ProposalReport>& proposals, const MapperInput& input,
             const OcclusionMaps& occluders, FrameReport& report);
  std::optional<MapObject> Spawn(const ProposalReport& proposal, const MapperInput& input,
                                 const OrientedTable& wide_table, const OcclusionMaps& occluders);
  /// What is planted becomes a candidate.
  void SpawnPlanted(const MapperInput& input, const OcclusionMaps& occluders, FrameReport& report);
  MapObject NewObject(std::string category, const MapperInput& input) const;
  /// Particles out of hypotheses, by how well they fit the image.
  void Populate(MapObject& object, const std::vector<PoseHypothesis>& drawn,
                const MapperInput& input, const OrientedTable& wide_table,
                const OcclusionMaps& occluders);
  void UpdateLifecycle(const MapperInput& input, double novelty, FrameReport& report);
  void KeepFrame(const MapperInput& input);
  /// Whether two poses are one, whatever their shapes.
  bool IsSamePose(const PoseHypothesis& pose, const PoseHypothesis& mean) const;
  /// Share of the particles near the mean pose, whatever their shape.
  double BeliefInMean(const MapObject& object) const;
  /// Whether a part of the belief that is in one place is elsewhere than the mean pose.
  bool HasRivalMode(const MapObject& object) const;
  void MergeDuplicates(double novelty, FrameReport& report);
  void Retire(MapObject& object, EventKind kind, ObjectId other, std::string why,
              FrameReport& report);
  /// The report of a frame, with what a resumed run goes on from.
  FrameReport Finished(FrameReport report) const;
};

}  // namespace plumbline
