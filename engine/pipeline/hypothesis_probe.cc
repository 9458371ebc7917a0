// SPDX-License-Identifier: Apache-2.0
#include "engine/pipeline/hypothesis_probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/evaluation/truth_pairing.h"
#include "engine/geometry/angles.h"
#include "engine/mapping/option_changes.h"
#include "engine/mapping/particle_rank.h"
#include "engine/pipeline/frame_pictures.h"
#include "engine/pipeline/hypothesis_frame.h"
#include "engine/snapshot/map_snapshot.h"

namespace plumbline {
namespace {

/// A particle this near to the truth would have been enough.
constexpr double kNear_m = 0.05, kNear_rad = 10 * kRadPerDeg;
constexpr double kLeastShown = 0.15;    ///< Of a contour, to say something about an instance.
constexpr double kLeastSurplus = 0.05;  ///< Of the edge term over chance.

ProbedHypothesis Named(std::string name, const PoseHypothesis& pose) {
  ProbedHypothesis hypothesis;
  hypothesis.name = std::move(name);
  hypothesis.label = pose.label;
  hypothesis.center_in_world = pose.center_in_world;
  hypothesis.azimuth_rad = pose.azimuth_rad;
  hypothesis.log_scale = pose.log_scale;
  return hypothesis;
}

bool IsNear(const ProbedHypothesis& hypothesis) {
  return *hypothesis.from_truth_m < kNear_m && *hypothesis.from_truth_rad < kNear_rad;
}

/// What a score has to be better by.
double Margin(const ProbeView& view) { return 0.02 * std::abs(view.alpha + view.beta); }

/// Whether it is the search or the likelihood. The last two hypotheses are the particle nearest to
/// the truth and the truth, if there is one.
Verdict VerdictOf(const ProbeView& view, bool has_truth, ObjectId explained_by) {
  if (!has_truth) return Verdict::kNoTruth;
  const ProbedHypothesis& mean = view.hypotheses.front();
  const ProbedHypothesis& nearest = view.hypotheses[view.hypotheses.size() - 2];
  const ProbedHypothesis& truth = view.hypotheses.back();
  if (*mean.from_truth_m > kPairReach_m) return Verdict::kSpurious;
  if (explained_by.value > 0) return Verdict::kSecond;
  if (IsNear(mean)) return Verdict::kRight;
  if (truth.score <= mean.score + Margin(view)) return Verdict::kLikelihood;
  return IsNear(nearest) && nearest.label == truth.label ? Verdict::kTime : Verdict::kSearch;
}

/// The only place where a verdict becomes words.
std::string SentenceOf(Verdict verdict, const ProbeView& view, const std::string& truth_id,
                       ObjectId explained_by) {
  const ProbedHypothesis& mean = view.hypotheses.front();
  const ProbedHypothesis& truth = view.hypotheses.back();
  switch (verdict) {
    case Verdict::kNoTruth:
      return "There is no true object of this category nearby to compare with.";
    case Verdict::kRight:
      return "It is where it should be.";
    case Verdict::kSpurious:
      return fmt::format(
          "Spurious: the nearest true object of this category{} is {:.0f} cm away; here the score "
          "is {:.2f}, there {:.2f}.",
          explained_by.value > 0 ? fmt::format(", which object {} explains,", explained_by.value)
                                 : std::string(),
          100 * *mean.from_truth_m, mean.score, truth.score);
    case Verdict::kSecond:
      return fmt::format(
          "A second one: object {} explains {}, which is {:.0f} cm away, and there is no other "
          "true object of this category nearby.",
          explained_by.value, truth_id, 100 * *mean.from_truth_m);
    case Verdict::kLikelihood:
      return fmt::format(
          "Likelihood: in this frame the wrong place scores {:.2f}, the truth {:.2f}. No search "
          "can find what does not score; look at edges, model and truth.",
          mean.score, truth.score);
    case Verdict::kSearch: {
      const ProbedHypothesis& nearest = view.hypotheses[view.hypotheses.size() - 2];
      return fmt::format(
          "Search: the truth would score {:.2f} against {:.2f}, but the nearest particle is {:.0f} "
          "cm and {:.0f}\u00b0 away.",
          truth.score, mean.score, 100 * *nearest.from_truth_m,
          *nearest.from_truth_rad / kRadPerDeg);
    }
    case Verdict::kTime:
      return fmt::format(
          "Time: the truth scores better ({:.2f} against {:.2f}) and there are particles near it; "
          "the weights have not followed yet.",
          truth.score, mean.score);
  }
  return "";
}

/// Of an instance that was asked about, which is the first hypothesis; the candidate's mean is the
/// second, if there is one.
void JudgeTruth(ObjectId candidate, ProbeView& view) {
  const ProbedHypothesis& truth = view.hypotheses.front();
  const auto say = [&](Verdict verdict, std::string text) {
    view.verdict = verdict;
    view.verdict_text = std::move(text);
  };
  if (truth.visible_fraction < kLeastShown) {
    return say(Verdict::kNoTruth,
               fmt::format("In this frame {:.0f} % of its contour shows: too little to say more.",
                           100 * truth.visible_fraction));
  }
  if (truth.phi_edge < view.chance + kLeastSurplus) {
    return say(Verdict::kLikelihood,
               fmt::format("In this frame the truth itself hardly meets edges ({:.2f}, by chance "
                           "{:.2f}): weak edges, another shape, or a doubtful truth.",
                           truth.phi_edge, view.chance));
  }
  if (candidate.value <= 0) {
    return say(Verdict::kSearch,
               fmt::format("In this frame the truth would score {:.2f} (edges {:.2f}, by chance "
                           "{:.2f}); no candidate is within a metre.",
                           truth.score, truth.phi_edge, view.chance));
  }
  const ProbedHypothesis& mean = view.hypotheses[1];
  if (IsNear(mean))
    return say(Verdict::kRight, fmt::format("In this frame object {} is there.", candidate.value));
  const bool better = truth.score > mean.score + Margin(view);
  say(better ? Verdict::kSearch : Verdict::kLikelihood,
      fmt::format("In this frame the truth would score {:.2f}; object {}, {:.0f} cm and "
                  "{:.0f}\u00b0 away, scores {:.2f}: {}.",
                  truth.score, candidate.value, 100 * *mean.from_truth_m,
                  *mean.from_truth_rad / kRadPerDeg, mean.score,
                  better ? "search has not found the better place"
                         : "no search finds a place that scores less"));
}

}  // namespace

Result<std::unique_ptr<HypothesisProbe>> HypothesisProbe::Create(
    const PinholeCamera& camera, std::shared_ptr<const ModelDatabase> database,
    std::optional<Eigen::Vector4d> floor_in_world, const WorkContext& work) {
  std::unique_ptr<HypothesisProbe> probe(new HypothesisProbe);
  probe->camera_ = camera;
  probe->database_ = database;
  probe->floor_in_world_ = floor_in_world;
  std::vector<std::shared_ptr<const ViewpointModel>> viewpoints;
  for (const CadModel& model : database->models()) {
    auto views = ViewpointModel::LoadOrBuild(model, ViewpointsOf(model), CacheDirectory(), work);
    if (!views.ok()) return views.error();
    viewpoints.push_back(*views);
  }
  probe->renderer_ = std::make_unique<OcclusionRenderer>(*database);
  probe->scorer_ = std::make_unique<ViewpointScorer>(std::move(viewpoints), database);
  return probe;
}

std::vector<Likelihood> HypothesisProbe::Score(const Frame& frame, const HypothesisScorer& scorer,
                                               std::span<const PoseHypothesis> hypotheses) const {
  const float normalizer = &scorer == scorer_.get() ? frame.normalizer : frame.reference_normalizer;
  return Evaluate(scorer, frame.view, frame.map, frame.detections.get(), hypotheses, normalizer,
                  options_);
}

ProbeView HypothesisProbe::Probe(const MapSnapshot& snapshot, const SequenceView& sequence,
                                 const MapperOptions& options, const ProbeCommand& request,
                                 const ProbedTruth& truth) {
  if (!OptionChanges(options_, options).empty()) table_ = nullptr;
  options_ = options;
  ProbeView view;
  view.frame = snapshot.report.frame;
  view.object = request.truth.empty() ? request.object : ObjectId();
  view.truth = request.truth;
  view.beta = options_.beta;
  view.search_radius_px = static_cast<float>(SearchOptions(options_, camera_.fx).radius_px);
  Frame frame{{UprightFrame(-sequence.up_in_world), floor_in_world_, database_}};
  for (const ObjectReport& object : snapshot.report.objects) {
    if (object.id == request.object) frame.object = &object;
  }
  const auto nothing = [&](const char* why) {
    view.message = why;
    return view;
  };
  const bool of_truth = !request.truth.empty();
  if (of_truth && !truth.index) return nothing("The ground truth has no such instance.");
  if (!of_truth && frame.object == nullptr) return nothing("The object is not in this frame.");
  if (!snapshot.report.world_from_cam || snapshot.edge_probability.empty())
    return nothing("Without the images of the sequence nothing can be scored again.");
  if (frame.object != nullptr &&
      (frame.object->particles == nullptr || frame.object->particles->empty())) {
    if (!of_truth) return nothing("The object has no particles in this frame.");
    frame.object = nullptr;
  }
  if (truth.index) {
    frame.truth = &sequence.truth[static_cast<std::size_t>(*truth.index)];
    frame.explained_by = truth.explained_by;
    const auto label = database_->Find(frame.truth->model);
    if (!label) return nothing("The models of the run lack that of the true instance.");
    PoseMode mode;
    mode.label = *label;
    mode.world_from_object = frame.truth->world_from_object;
    mode.scale = frame.truth->scale;
    frame.truth_hypothesis = ToHypothesis(mode, frame.map);
  }
  const CadModel& asked =
      database_->model(of_truth ? frame.truth_hypothesis.label : frame.object->label);
  const bool confirmed = !of_truth && frame.object->state == ObjectState::kConfirmed;
  view.alpha = confirmed ? options_.alpha : DetectorWeight(asked.category, asked.bounds, options_);
  frame.world_from_axes =
      of_truth ? *snapshot.report.world_from_cam : frame.object->world_from_reference_cam;

  frame.view.camera = camera_;
  frame.view.cam_from_world = snapshot.report.world_from_cam->inverse();
  if (frame.object != nullptr) {
    PoseMode mean;
    mean.label = frame.object->label;
    mean.world_from_object = frame.object->world_from_object;
    mean.scale = frame.object->scale;
    frame.mean = ToHypothesis(mean, frame.map);
  }
  const bool afar = confirmed && IsAfar(frame.map, frame.mean, frame.view.cam_from_world, options_);
  frame.search =
      afar ? NarrowSearchOptions(options_, camera_.fx) : SearchOptions(options_, camera_.fx);
  const EdgeMap edges{snapshot.edge_probability, snapshot.edge_angle};
  if (table_frame_ != view.frame || table_ == nullptr || table_is_narrow_ != afar) {
    table_ = std::make_shared<const OrientedTable>(edges, frame.search);
    table_frame_ = view.frame;
    table_is_narrow_ = afar;
  }
  view.chance = static_cast<float>(table_->chance());
  frame.view.table = table_.get();
  std::vector<PlacedModel> others;
  for (const ObjectReport& object : snapshot.report.objects) {
    if (object.id != request.object && object.state == ObjectState::kConfirmed)
      others.push_back({object.id, object.label, object.world_from_object, object.scale});
  }
  const OcclusionMaps maps = renderer_->RenderOccluders(camera_, frame.view.cam_from_world, others);
  frame.view.occluder_depth =
      confirmed && asked.support == Support::kFloor
          ? maps.DepthAndContours(request.object, {}, ContoursOf::kRaisedThings)
          : maps.DepthBefore(request.object);
  frame.view.occlusion_margin_m = options_.occlusion_margin_m;
  frame.view.luminance_behind = maps.LuminanceBehind(request.object);
  frame.view.least_contrast = options_.least_contrast;
  frame.view.rims = confirmed;
  std::vector<Detection> proposals;
  for (const ProposalReport& proposal : snapshot.report.proposals)
    proposals.push_back({proposal.box, proposal.category, proposal.score});
  frame.detections = DetectionsFromProposals(std::move(proposals));
  if (frame.object != nullptr) {
    for (const Particle& particle : *frame.object->particles)
      frame.particles.push_back(ToHypothesis(particle, frame.object->world_from_reference_cam));
  }
  const std::vector<PoseHypothesis> typical =
      frame.particles.empty() ? std::vector<PoseHypothesis>{frame.truth_hypothesis}
                              : frame.particles;
  std::vector<HypothesisScore> scores(typical.size());
  scorer_->Score(frame.view, frame.map.upright, typical, scores);
  frame.normalizer = EdgeNormalizer(scores);
  frame.reference_normalizer = frame.normalizer;

  if (request.reference && reference_ == nullptr && !reference_failed_) {
    auto made = RenderedScorer::Create(database_, {});
    reference_failed_ = !made.ok();
    if (made.ok()) reference_ = std::move(made).value();
    if (!made.ok()) log::warn("no reference scorer: {}", made.error().message);
  }
  const HypothesisScorer* reference = request.reference ? reference_.get() : nullptr;
  AddHypotheses(frame, request, view);
  ScoreHypotheses(frame, reference, edges, view);
  AddOutlines(frame, request.hovered, view);
  AddSlices(frame, reference, view);
  if (request.maps) {
    const std::vector<Axis> axes = Axes(frame, view);
    AddMap(frame, axes[0], axes[2], view);
    AddMap(frame, axes[3], axes[2], view);
  }
  return view;
}

void HypothesisProbe::AddHypotheses(const Frame& frame, const ProbeCommand& request,
                                    ProbeView& view) const {
  const auto add_truth = [&] {
    view.hypotheses.push_back(Named("truth " + frame.truth->id, frame.truth_hypothesis));
    view.hypotheses.back().is_truth = true;
  };
  const bool truth_first = !request.truth.empty();
  if (truth_first) add_truth();
  if (frame.object != nullptr) {
    view.hypotheses.push_back(Named(
        truth_first ? fmt::format("mean of #{}", frame.object->id.value) : "mean", frame.mean));
    AddParticles(frame, request, view);
  }
  if (!truth_first && frame.truth != nullptr) add_truth();
}

/// The best, the median, the one asked for, and the one nearest to the truth.
void HypothesisProbe::AddParticles(const Frame& frame, const ProbeCommand& request,
                                   ProbeView& view) const {
  const std::vector<Particle>& particles = *frame.object->particles;
  const std::vector<int> by_rank = ByRank(particles, view.alpha, options_.beta);
  const auto add_particle = [&](const char* name, int index) {
    view.hypotheses.push_back(Named(fmt::format("{} ({})", name, index),
                                    frame.particles[static_cast<std::size_t>(index)]));
    view.hypotheses.back().particle = index;
  };
  add_particle("best particle", by_rank.front());
  add_particle("median particle", by_rank[by_rank.size() / 2]);
  if (request.particle >= 0 && request.particle < static_cast<int>(particles.size()))
    add_particle("particle", request.particle);
  if (frame.truth == nullptr) return;
  int nearest = 0;
  double nearest_distance = 1e9;
  view.nearest_particle_m = 1e9f;
  for (std::size_t i = 0; i < frame.particles.size(); ++i) {
    const PoseHypothesis& p = frame.particles[i];
    const double meters = (p.center_in_world - frame.truth_hypothesis.center_in_world).norm();
    const double turned = std::abs(frame.AzimuthFromTruth(p.azimuth_rad));
    const double distance =
        meters + 0.3 * turned + (p.label == frame.truth_hypothesis.label ? 0.0 : 0.1);
    if (distance >= nearest_distance) continue;
    nearest_distance = distance;
    nearest = static_cast<int>(i);
    view.nearest_particle_m = static_cast<float>(meters);
  }
  add_particle("nearest to truth", nearest);
}

void HypothesisProbe::ScoreHypotheses(const Frame& frame, const HypothesisScorer* reference,
                                      const EdgeMap& edges, ProbeView& view) const {
  std::vector<PoseHypothesis> poses;
  for (const ProbedHypothesis& h : view.hypotheses)
    poses.push_back({h.label, h.azimuth_rad, h.center_in_world, h.log_scale});
  const std::vector<Likelihood> scored = Score(frame, *scorer_, poses);
  std::vector<Likelihood> rendered;
  if (reference != nullptr) rendered = Score(frame, *reference, poses);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    ProbedHypothesis& h = view.hypotheses[i];
    h.phi_cnn = scored[i].phi_cnn;
    h.phi_edge = scored[i].phi_edge;
    h.score = static_cast<float>(view.alpha * h.phi_cnn + view.beta * h.phi_edge);
    h.visible_fraction = scored[i].visible_fraction;
    h.whole_box = scored[i].whole_box;
    h.visible_box = scored[i].visible_box;
    if (!rendered.empty()) h.phi_edge_rendered = rendered[i].phi_edge;
    if (frame.truth != nullptr) {
      h.from_truth_m =
          static_cast<float>((h.center_in_world - frame.truth_hypothesis.center_in_world).norm());
      h.from_truth_rad = static_cast<float>(std::abs(frame.AzimuthFromTruth(h.azimuth_rad)));
    }
    h.samples = Samples(frame, poses[i], edges);
  }
  if (!view.truth.empty())
    return JudgeTruth(frame.object != nullptr ? frame.object->id : ObjectId(), view);
  view.verdict = VerdictOf(view, frame.truth != nullptr, frame.explained_by);
  view.verdict_text = SentenceOf(*view.verdict, view, frame.truth != nullptr ? frame.truth->id : "",
                                 frame.explained_by);
}

void HypothesisProbe::AddOutlines(const Frame& frame, int hovered, ProbeView& view) {
  const cv::Size size(camera_.width, camera_.height);
  const auto outline = [&](const PoseHypothesis& pose) {
    const PlacedModel placed[] = {
        {ObjectId{1}, pose.label, frame.map.WorldFromObject(pose), pose.scale()}};
    const RenderedMaps maps = renderer_->Render(camera_, frame.view.cam_from_world, placed);
    std::vector<OutlineView> outlines = OutlinesOf(maps.id, size);
    return outlines.empty() ? std::vector<std::vector<Eigen::Vector2f>>()
                            : std::move(outlines.front().contours);
  };
  for (ProbedHypothesis& h : view.hypotheses)
    h.outline = outline({h.label, h.azimuth_rad, h.center_in_world, h.log_scale});
  if (hovered < 0 || hovered >= static_cast<int>(frame.particles.size())) return;
  view.hovered = hovered;
  view.hovered_outline = outline(frame.particles[static_cast<std::size_t>(hovered)]);
}

ProbeView LazyProbe::Probe(const MapSnapshot& snapshot, const SequenceView& sequence,
                           const MapperOptions& options, const ProbeCommand& request,
                           const ProbedTruth& truth) {
  if (probe_ == nullptr) {
    auto made = HypothesisProbe::Create(camera_, database_, floor_in_world_, WorkContext());
    if (!made.ok()) {
      ProbeView failed;
      failed.frame = snapshot.report.frame;
      failed.object = request.truth.empty() ? request.object : ObjectId();
      failed.truth = request.truth;
      failed.message = made.error().message;
      return failed;
    }
    probe_ = std::move(made).value();
  }
  return probe_->Probe(snapshot, sequence, options, request, truth);
}

}  // namespace plumbline
