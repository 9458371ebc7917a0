// SPDX-License-Identifier: Apache-2.0
#include "engine/process/hypothesis_probe.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/base/files.h"
#include "engine/base/log.h"
#include "engine/process/frame_pictures.h"

namespace plumbline {
namespace {

constexpr int kSliceSteps = 61, kMapSteps = 41;
constexpr double kDegree = std::numbers::pi / 180;
constexpr double kFarthestTruth_m = 1.5;
constexpr double kSpurious_m = 0.5;  ///< Further off than evaluation pairs estimates with truth.
/// A particle this near to the truth would have been enough.
constexpr double kNear_m = 0.05, kNear_rad = 10 * kDegree;

OrientedTableOptions TableOptions(const MapperOptions& options) {
  OrientedTableOptions table;
  table.radius_px = options.search_radius_px;
  table.sigma_px = options.search_sigma_px;
  table.power = options.edge_power;
  return table;
}

/// The edge that gives the best hit along the normal, as the search table counts it.
std::optional<float> BestEdge(const EdgeMap& edges, const OrientedTableOptions& options,
                              const Eigen::Vector2f& pixel, const Eigen::Vector2f& normal) {
  std::optional<float> best_at;
  double best = 0;
  const int radius = static_cast<int>(options.radius_px);
  for (int k = -radius; k <= radius; ++k) {
    const int x = static_cast<int>(std::lround(pixel.x() + static_cast<float>(k) * normal.x()));
    const int y = static_cast<int>(std::lround(pixel.y() + static_cast<float>(k) * normal.y()));
    if (x < 0 || y < 0 || x >= edges.probability.cols || y >= edges.probability.rows) continue;
    const double probability = edges.probability.at<std::uint8_t>(y, x) / 255.0;
    if (probability == 0) continue;
    const double angle = edges.angle.at<std::uint8_t>(y, x) * std::numbers::pi / 256;
    const double agreement = std::abs(std::cos(angle) * normal.x() + std::sin(angle) * normal.y());
    if (agreement < options.min_agreement) continue;
    const double hit = std::pow(probability, options.power) *
                       std::exp(-0.5 * k * k / (options.sigma_px * options.sigma_px));
    if (hit <= best) continue;
    best = hit;
    best_at = static_cast<float>(k);
  }
  return best_at;
}

}  // namespace

struct HypothesisProbe::Frame {
  MapFrame map;
  ScoringView view;
  std::unique_ptr<const FrameDetections> detections;
  const ObjectReport* object = nullptr;
  std::vector<PoseHypothesis> particles;
  float normalizer = 0, reference_normalizer = 0;
  const SequenceView::Truth* truth = nullptr;  ///< Nearest of the object's category.
  PoseHypothesis truth_hypothesis;

  double AzimuthFromTruth(double azimuth_rad) const {
    return AzimuthDifference(map.database->model(truth_hypothesis.label), azimuth_rad,
                             truth_hypothesis.azimuth_rad);
  }
};

/// A parameter that is swept about the mean.
struct HypothesisProbe::Axis {
  const char* name;
  const char* unit;
  double reach;     ///< In m or rad.
  double per_unit;  ///< `unit` per m or rad.
  Eigen::Vector3d direction;
  std::optional<float> truth;  ///< Offset of the true place, in `unit`.

  bool turns() const { return direction.isZero(); }
  double Offset(int step, int steps) const { return reach * (2.0 * step / (steps - 1) - 1); }
  void Move(double offset, PoseHypothesis& pose) const {
    if (turns())
      pose.azimuth_rad += offset;
    else
      pose.center_in_world += offset * direction;
  }
};

Result<std::unique_ptr<HypothesisProbe>> HypothesisProbe::Create(
    const PinholeCamera& camera, std::shared_ptr<const ModelDatabase> database,
    const MapperOptions& options, std::optional<Eigen::Vector4d> floor_in_world,
    const WorkContext& work) {
  std::unique_ptr<HypothesisProbe> probe(new HypothesisProbe);
  probe->camera_ = camera;
  probe->database_ = database;
  probe->options_ = options;
  probe->floor_in_world_ = floor_in_world;
  for (const CadModel& model : database->models()) {
    auto views = ViewpointModel::LoadOrBuild(model, {}, CacheDirectory(), work);
    if (!views.ok()) return views.error();
    probe->viewpoints_.push_back(*views);
  }
  auto renderer = OcclusionRenderer::Create(database);
  if (!renderer.ok()) return renderer.error();
  probe->renderer_ = std::move(renderer).value();
  probe->scorer_ = std::make_unique<ViewpointScorer>(probe->viewpoints_, database);
  return probe;
}

std::vector<Likelihood> HypothesisProbe::Score(const Frame& frame, const HypothesisScorer& scorer,
                                               std::span<const PoseHypothesis> hypotheses) const {
  const float normalizer = &scorer == scorer_.get() ? frame.normalizer : frame.reference_normalizer;
  return Evaluate(scorer, frame.view, frame.map, frame.detections.get(), hypotheses, normalizer,
                  options_);
}

ProbeView HypothesisProbe::Probe(const MapSnapshot& snapshot, const SequenceView& sequence,
                                 const ProbeCommand& request) {
  ProbeView view;
  view.frame = snapshot.report.frame;
  view.object = request.object;
  view.alpha = options_.alpha;
  view.beta = options_.beta;
  view.search_radius_px = static_cast<float>(options_.search_radius_px);
  Frame frame{{UprightFrame(-sequence.up_in_world), floor_in_world_, database_}};
  for (const ObjectReport& object : snapshot.report.objects) {
    if (object.id == request.object) frame.object = &object;
  }
  const auto nothing = [&](const char* why) {
    view.message = why;
    return view;
  };
  if (frame.object == nullptr) return nothing("The object is not in this frame.");
  if (!snapshot.report.world_from_cam || snapshot.edge_probability.empty())
    return nothing("Without the images of the sequence nothing can be scored again.");
  if (frame.object->particles == nullptr || frame.object->particles->empty())
    return nothing("The object has no particles in this frame.");

  const EdgeMap edges{snapshot.edge_probability, snapshot.edge_angle};
  if (table_frame_ != view.frame || table_ == nullptr) {
    table_ = std::make_shared<const OrientedTable>(edges, TableOptions(options_));
    table_frame_ = view.frame;
  }
  view.chance = static_cast<float>(table_->chance());
  frame.view.camera = camera_;
  frame.view.cam_from_world = snapshot.report.world_from_cam->inverse();
  frame.view.table = table_.get();
  std::vector<PlacedModel> others;
  for (const ObjectReport& object : snapshot.report.objects) {
    if (object.id != request.object && object.state == ObjectState::kConfirmed)
      others.push_back({object.id, object.label, object.world_from_object});
  }
  frame.view.occluder_depth = renderer_->Render(camera_, frame.view.cam_from_world, others).depth;
  frame.view.occlusion_margin_m = options_.occlusion_margin_m;
  std::vector<Detection> proposals;
  for (const ProposalReport& proposal : snapshot.report.proposals)
    proposals.push_back({proposal.box, proposal.category, proposal.score});
  frame.detections = DetectionsFromProposals(std::move(proposals));
  for (const Particle& particle : *frame.object->particles)
    frame.particles.push_back(ToHypothesis(particle, frame.object->world_from_reference_cam));
  std::vector<HypothesisScore> scores(frame.particles.size());
  scorer_->Score(frame.view, frame.map.upright, frame.particles, scores);
  frame.normalizer = EdgeNormalizer(scores);
  frame.reference_normalizer = frame.normalizer;

  if (request.reference && reference_ == nullptr && !reference_failed_) {
    auto made = RenderedScorer::Create(database_, {});
    reference_failed_ = !made.ok();
    if (made.ok()) reference_ = std::move(made).value();
    if (!made.ok()) log::warn("no reference scorer: {}", made.error().message);
  }
  const HypothesisScorer* reference = request.reference ? reference_.get() : nullptr;
  AddHypotheses(frame, sequence, request, view);
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

void HypothesisProbe::AddHypotheses(Frame& frame, const SequenceView& sequence,
                                    const ProbeCommand& request, ProbeView& view) const {
  const ObjectReport& object = *frame.object;
  const auto add = [&](std::string name, const PoseHypothesis& pose, std::optional<int> particle,
                       bool is_truth) {
    ProbedHypothesis hypothesis;
    hypothesis.name = std::move(name);
    hypothesis.particle = particle;
    hypothesis.is_truth = is_truth;
    hypothesis.label = pose.label;
    hypothesis.center_in_world = pose.center_in_world;
    hypothesis.azimuth_rad = pose.azimuth_rad;
    view.hypotheses.push_back(std::move(hypothesis));
  };
  PoseMode mean;
  mean.label = object.label;
  mean.world_from_object = object.world_from_object;
  add("mean", ToHypothesis(mean, frame.map), std::nullopt, false);

  double nearest_m = kFarthestTruth_m;
  for (const SequenceView::Truth& truth : sequence.truth) {
    const auto label = database_->Find(truth.model);
    if (!label || database_->model(*label).category != object.category) continue;
    const double distance_m =
        (truth.world_from_object.translation() - object.world_from_object.translation()).norm();
    if (distance_m >= nearest_m) continue;
    nearest_m = distance_m;
    frame.truth = &truth;
    PoseMode mode;
    mode.label = *label;
    mode.world_from_object = truth.world_from_object;
    frame.truth_hypothesis = ToHypothesis(mode, frame.map);
  }

  const std::vector<Particle>& particles = *object.particles;
  std::vector<int> by_weight(particles.size());
  for (std::size_t i = 0; i < particles.size(); ++i) by_weight[i] = static_cast<int>(i);
  // After resampling all weigh the same: then the better score goes first.
  const auto score = [&](int i) {
    const Particle& p = particles[static_cast<std::size_t>(i)];
    return p.log_weight + options_.alpha * p.phi_cnn + options_.beta * p.phi_edge;
  };
  std::sort(by_weight.begin(), by_weight.end(), [&](int a, int b) { return score(a) > score(b); });
  const auto add_particle = [&](const char* name, int index) {
    add(fmt::format("{} ({})", name, index), frame.particles[static_cast<std::size_t>(index)],
        index, false);
  };
  add_particle("best particle", by_weight.front());
  add_particle("median particle", by_weight[by_weight.size() / 2]);
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
  add("truth " + frame.truth->id, frame.truth_hypothesis, std::nullopt, true);
}

void HypothesisProbe::ScoreHypotheses(const Frame& frame, const HypothesisScorer* reference,
                                      const EdgeMap& edges, ProbeView& view) const {
  std::vector<PoseHypothesis> poses;
  for (const ProbedHypothesis& h : view.hypotheses)
    poses.push_back({h.label, h.azimuth_rad, h.center_in_world});
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
  if (frame.truth == nullptr) {
    view.verdict = "There is no true object of this category nearby to compare with.";
    return;
  }
  const ProbedHypothesis& mean = view.hypotheses.front();
  const ProbedHypothesis& nearest = view.hypotheses[view.hypotheses.size() - 2];
  const ProbedHypothesis& truth = view.hypotheses.back();
  const double margin = 0.02 * std::abs(view.alpha + view.beta);
  const bool near = *nearest.from_truth_m < kNear_m && *nearest.from_truth_rad < kNear_rad &&
                    nearest.label == truth.label;
  if (*mean.from_truth_m < kNear_m && *mean.from_truth_rad < kNear_rad) {
    view.verdict = "It is where it should be.";
  } else if (*mean.from_truth_m > kSpurious_m) {
    view.verdict = fmt::format(
        "Spurious: the nearest true object of this category is {:.0f} cm away; here the score is "
        "{:.2f}, there {:.2f}.",
        100 * *mean.from_truth_m, mean.score, truth.score);
  } else if (truth.score <= mean.score + margin) {
    view.verdict = fmt::format(
        "Likelihood: in this frame the wrong place scores {:.2f}, the truth {:.2f}. No search can "
        "find what does not score; look at edges, model and truth.",
        mean.score, truth.score);
  } else if (!near) {
    view.verdict = fmt::format(
        "Search: the truth would score {:.2f} against {:.2f}, but the nearest particle is {:.0f} "
        "cm "
        "and {:.0f}\u00b0 away.",
        truth.score, mean.score, 100 * *nearest.from_truth_m, *nearest.from_truth_rad / kDegree);
  } else {
    view.verdict = fmt::format(
        "Time: the truth scores better ({:.2f} against {:.2f}) and there are particles near it; "
        "the "
        "weights have not followed yet.",
        truth.score, mean.score);
  }
}

void HypothesisProbe::AddOutlines(const Frame& frame, int hovered, ProbeView& view) {
  const cv::Size size(camera_.width, camera_.height);
  const auto outline = [&](const PoseHypothesis& pose) {
    const PlacedModel placed[] = {{frame.object->id, pose.label, frame.map.WorldFromObject(pose)}};
    const RenderedMaps maps = renderer_->Render(camera_, frame.view.cam_from_world, placed);
    std::vector<OutlineView> outlines = OutlinesOf(maps.id, size);
    return outlines.empty() ? std::vector<std::vector<Eigen::Vector2f>>()
                            : std::move(outlines.front().contours);
  };
  for (ProbedHypothesis& h : view.hypotheses)
    h.outline = outline({h.label, h.azimuth_rad, h.center_in_world});
  if (hovered < 0 || hovered >= static_cast<int>(frame.particles.size())) return;
  view.hovered = hovered;
  view.hovered_outline = outline(frame.particles[static_cast<std::size_t>(hovered)]);
}

std::vector<HypothesisProbe::Axis> HypothesisProbe::Axes(const Frame& frame,
                                                         const ProbeView& view) {
  const Eigen::Isometry3d& world_from_cam = frame.object->world_from_reference_cam;
  const ProbedHypothesis& mean = view.hypotheses.front();
  const Eigen::Vector3d ray = (mean.center_in_world - world_from_cam.translation()).normalized();
  std::vector<Axis> axes = {{"sideways", "cm", 0.3, 100, world_from_cam.linear().col(0)},
                            {"down", "cm", 0.3, 100, world_from_cam.linear().col(1)},
                            {"distance", "cm", 0.5, 100, ray},
                            {"azimuth", "\u00b0", std::numbers::pi, 1 / kDegree, {0, 0, 0}}};
  if (frame.truth == nullptr) return axes;
  for (Axis& axis : axes) {
    const double offset =
        axis.turns()
            ? -frame.AzimuthFromTruth(mean.azimuth_rad)
            : (frame.truth_hypothesis.center_in_world - mean.center_in_world).dot(axis.direction);
    axis.truth = static_cast<float>(offset * axis.per_unit);
  }
  return axes;
}

void HypothesisProbe::AddSlices(const Frame& frame, const HypothesisScorer* reference,
                                ProbeView& view) const {
  const ProbedHypothesis& mean = view.hypotheses.front();
  for (const Axis& axis : Axes(frame, view)) {
    LikelihoodSlice slice{axis.name, axis.unit, {}, {}, {}, {}, {}, axis.truth};
    std::vector<PoseHypothesis> poses;
    for (int i = 0; i < kSliceSteps; ++i) {
      const double offset = axis.Offset(i, kSliceSteps);
      slice.offsets.push_back(static_cast<float>(offset * axis.per_unit));
      poses.push_back({mean.label, mean.azimuth_rad, mean.center_in_world});
      axis.Move(offset, poses.back());
    }
    for (const Likelihood& likelihood : Score(frame, *scorer_, poses)) {
      slice.phi_cnn.push_back(likelihood.phi_cnn);
      slice.phi_edge.push_back(likelihood.phi_edge);
      slice.score.push_back(
          static_cast<float>(view.alpha * likelihood.phi_cnn + view.beta * likelihood.phi_edge));
    }
    if (reference != nullptr) {
      for (const Likelihood& likelihood : Score(frame, *reference, poses))
        slice.phi_edge_rendered.push_back(likelihood.phi_edge);
    }
    view.slices.push_back(std::move(slice));
  }
}

void HypothesisProbe::AddMap(const Frame& frame, const Axis& x, const Axis& y,
                             ProbeView& view) const {
  const ProbedHypothesis& mean = view.hypotheses.front();
  LikelihoodMap map{x.name, x.unit, y.name, y.unit, {}, {}, {}, {}, {}, {}};
  std::vector<PoseHypothesis> poses;
  for (int row = 0; row < kMapSteps; ++row) {
    map.x_offsets.push_back(static_cast<float>(x.Offset(row, kMapSteps) * x.per_unit));
    map.y_offsets.push_back(static_cast<float>(y.Offset(row, kMapSteps) * y.per_unit));
    for (int column = 0; column < kMapSteps; ++column) {
      poses.push_back({mean.label, mean.azimuth_rad, mean.center_in_world});
      x.Move(x.Offset(column, kMapSteps), poses.back());
      y.Move(y.Offset(row, kMapSteps), poses.back());
    }
  }
  for (const Likelihood& likelihood : Score(frame, *scorer_, poses)) {
    map.phi_cnn.push_back(likelihood.phi_cnn);
    map.phi_edge.push_back(likelihood.phi_edge);
    map.score.push_back(
        static_cast<float>(view.alpha * likelihood.phi_cnn + view.beta * likelihood.phi_edge));
  }
  if (x.truth && y.truth) map.truth = Eigen::Vector2f(*x.truth, *y.truth);
  view.maps.push_back(std::move(map));
}

std::vector<ContourSample> HypothesisProbe::Samples(const Frame& frame,
                                                    const PoseHypothesis& hypothesis,
                                                    const EdgeMap& edges) const {
  const auto& model = viewpoints_[static_cast<std::size_t>(hypothesis.label.value)];
  const Eigen::Vector3d center = database_->model(hypothesis.label).center();
  const Eigen::Matrix3d world_from_object =
      frame.map.upright.WorldFromObjectRotation(hypothesis.azimuth_rad);
  const Eigen::Isometry3d& cam_from_world = frame.view.cam_from_world;
  const Eigen::Vector3d camera_in_object =
      world_from_object.transpose() *
          (cam_from_world.inverse().translation() - hypothesis.center_in_world) +
      center;
  const ContourView contour = model->View(camera_in_object.cast<float>());
  const Eigen::Matrix3d rotation = cam_from_world.linear() * world_from_object;
  const Eigen::Vector3d translation =
      cam_from_world * hypothesis.center_in_world - rotation * center;
  const OrientedTableOptions table_options = TableOptions(options_);
  const cv::Mat& occluder = frame.view.occluder_depth;
  std::vector<ContourSample> samples;
  for (int i = 0; i < contour.size; ++i) {
    const Eigen::Vector3d p =
        rotation * Eigen::Vector3d(contour.x[i], contour.y[i], contour.z[i]) + translation;
    if (p.z() < frame.view.near_m) continue;
    const Eigen::Vector3d n =
        rotation * Eigen::Vector3d(contour.nx[i], contour.ny[i], contour.nz[i]);
    const double bx = p.x() / p.z(), by = p.y() / p.z();
    ContourSample sample;
    sample.pixel =
        Eigen::Vector2d(camera_.fx * bx + camera_.cx, camera_.fy * by + camera_.cy).cast<float>();
    sample.normal =
        Eigen::Vector2d(camera_.fx * (n.x() - n.z() * bx), camera_.fy * (n.y() - n.z() * by))
            .normalized()
            .cast<float>();
    const int x = static_cast<int>(std::floor(sample.pixel.x() + 0.5f));
    const int y = static_cast<int>(std::floor(sample.pixel.y() + 0.5f));
    if (x < 0 || y < 0 || x >= table_->width() || y >= table_->height()) continue;
    sample.visible = true;
    if (!occluder.empty()) {
      const float in_front = occluder.at<float>(y * occluder.rows / table_->height(),
                                                x * occluder.cols / table_->width());
      sample.visible = !(in_front > 0 && in_front < p.z() - frame.view.occlusion_margin_m);
    }
    double turn = std::atan2(sample.normal.y(), sample.normal.x()) / std::numbers::pi;
    turn -= std::floor(turn);
    const int bin =
        std::min(OrientedTable::kBins - 1, static_cast<int>(turn * OrientedTable::kBins));
    sample.hit = static_cast<float>(table_->Hit(x, y, bin)) / 255.0f;
    sample.edge_at_px = BestEdge(edges, table_options, sample.pixel, sample.normal);
    samples.push_back(sample);
  }
  return samples;
}

ProbeView LazyProbe::Probe(const MapSnapshot& snapshot, const SequenceView& sequence,
                           const ProbeCommand& request) {
  if (probe_ == nullptr) {
    auto made =
        HypothesisProbe::Create(camera_, database_, options_, floor_in_world_, WorkContext());
    if (!made.ok()) {
      ProbeView failed;
      failed.frame = snapshot.report.frame;
      failed.object = request.object;
      failed.message = made.error().message;
      return failed;
    }
    probe_ = std::move(made).value();
  }
  return probe_->Probe(snapshot, sequence, request);
}

}  // namespace plumbline
