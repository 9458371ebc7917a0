// SPDX-License-Identifier: Apache-2.0
// A frame of the authors' filter (docs/algorithms/paper_filter.md).
#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "engine/mapping/association.h"
#include "engine/mapping/mapper_impl.h"

namespace plumbline {
namespace {

constexpr float kTentativeBoxIou = 0.5f, kSettledBoxIou = 0.7f;  ///< Of a box with its object.
constexpr double kExplainedShare = 0.7;  ///< Of a box, by the rectangles of all objects.
constexpr float kWidestBox = 4;          ///< Width to height, or height to width.
constexpr float kFillsImage = 0.9f;
constexpr int kForgottenFrames = 50;  ///< A settled object not updated for so long stays as it is.

cv::Rect PixelsOf(const Box2& box, const cv::Size& size) {
  const cv::Point from(cvRound(box.x0), cvRound(box.y0)), to(cvRound(box.x1), cvRound(box.y1));
  return cv::Rect(from, to + cv::Point(1, 1)) & cv::Rect({0, 0}, size);
}

EdgeMap Inside(const EdgeMap& edges, const Box2& box) {
  EdgeMap inside{cv::Mat::zeros(edges.probability.size(), CV_8U), edges.angle};
  const cv::Rect pixels = PixelsOf(box, edges.probability.size());
  edges.probability(pixels).copyTo(inside.probability(pixels));
  return inside;
}

}  // namespace

class Mapper::Impl::PaperStep {
 public:
  PaperStep(Impl& mapper, const MapperInput& input, double dt_s, FrameReport& report)
      : m_(mapper), input_(input), dt_s_(dt_s), report_(report) {}

  void Run() {
    StageClock stages(m_.boxes_ms, report_);
    occlusion_ = m_.renderer.RenderOccluders(m_.setup.camera, input_.world_from_cam.inverse(),
                                             m_.MeanStates(true));
    stages.End("visibility");
    levels_ = SearchLevels(input_.edges, options());
    if (input_.detections) {
      for (const Detection& detection : input_.detections->proposals())
        if (IsSeen(detection)) boxes_.push_back(detection);
    }
    owners_.resize(boxes_.size());
    for (MapObject& object : m_.objects) Update(object);
    stages.End("update");
    for (MapObject& object : m_.objects) Live(object);
    Merge();
    stages.End("explain");
    Spawn();
    m_.mean_maps =
        m_.renderer.Render(m_.setup.camera, input_.world_from_cam.inverse(), m_.MeanStates(false));
    stages.End("spawn");
    stages.EndFrame();
  }

 private:
  const PaperOptions& options() const { return m_.options().paper; }
  cv::Size ImageSize() const { return {m_.setup.camera.width, m_.setup.camera.height}; }

  bool IsSeen(const Detection& detection) const {
    const float shape = detection.box.width() / std::max(1.0f, detection.box.height());
    return detection.score >= options().min_score &&
           detection.box.area() >= options().min_box_share * ImageSize().area() &&
           shape <= kWidestBox && shape >= 1 / kWidestBox;
  }

  PaperImage Image(const MapObject& object, std::span<const NearestEdges> levels) const {
    return {m_.setup.scorer.get(), &m_.map, m_.View(input_, occlusion_, object.id), levels,
            input_.detections.get()};
  }

  /// Of its mean, at full size.
  EdgeMatch MatchOf(const MapObject& object, const ScoringView& view) const {
    const PoseHypothesis mean = ToHypothesis(object.mean(), m_.map);
    return levels_.back().Match(*m_.setup.scorer, view, m_.map.upright, {&mean, 1}).front();
  }

  /// Share of the contour inside the image that no other object hides.
  double Shown(const MapObject& object, const ScoringView& view) const {
    ScoringView open = view;
    open.occluder_depth.release();
    const float whole = MatchOf(object, open).visible_m;
    return whole > 0 ? MatchOf(object, view).visible_m / whole : 0;
  }

  bool IsInView(const MapObject& object) const {
    const Eigen::Vector3d center =
        input_.world_from_cam.inverse() * ToHypothesis(object.mean(), m_.map).center_in_world;
    if (center.z() <= 0) return false;
    const Eigen::Vector2d pixel = m_.setup.camera.Project(center);
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < ImageSize().width &&
           pixel.y() < ImageSize().height;
  }

  void Update(MapObject& object) {
    const PaperImage image = Image(object, levels_);
    const EdgeMatch before = MatchOf(object, image.view);
    object.whole_box = before.whole_box;
    object.visible_box = before.visible_box;
    object.visible_fraction = Shown(object, image.view);
    const bool settled = object.state == ObjectState::kConfirmed;
    object.updated = IsInView(object) && object.visible_fraction > options().min_visible &&
                     !(settled && input_.frame - object.last_frame >= kForgottenFrames);
    if (!object.updated) return;
    ++(TakeBox(object) ? object.paper.matched : object.paper.unmatched);
    const std::size_t count =
        settled ? static_cast<std::size_t>(m_.options().particles) : CountOf(object);
    UpdateParticles(object, image, count);
    object.last_frame = input_.frame;
    object.seen_s += dt_s_;
  }

  /// Particles of an object that has not settled.
  std::size_t CountOf(const MapObject& object) const {
    return static_cast<std::size_t>(options().particles_per_shape) *
           m_.map.database->OfCategory(object.category).size();
  }

  void UpdateParticles(MapObject& object, const PaperImage& image, std::size_t count) {
    const bool settled = object.state == ObjectState::kConfirmed;
    const std::optional<ModelId> label =
        object.modes.empty() ? std::nullopt : std::optional(object.mean().label);
    UpdateAsPaper(object.particles, object.world_from_reference_cam, image, options(),
                  {count, settled, Key(m_.setup.seed, input_.frame, object.id, Draw::kDiffuse),
                   Key(m_.setup.seed, input_.frame, object.id, Draw::kResample)});
    object.memory.assign(object.particles.size(), 0.0f);
    object.effective_sample_size = EffectiveSampleSize(object.particles);
    object.Summarize(m_.map);
    const PoseHypothesis mean = ToHypothesis(object.mean(), m_.map);
    object.paper.Add(ToParticle(mean, object.world_from_reference_cam), settled);
    object.updated = true;
    if (label && *label != object.mean().label) {
      report_.events.push_back(
          {EventKind::kLabelChanged,
           object.id,
           {},
           "now most likely " + m_.setup.database->model(object.mean().label).name});
    }
  }

  /// Gives it the best box that is its own, if there is one.
  bool TakeBox(const MapObject& object) {
    const float least = object.state == ObjectState::kConfirmed ? kSettledBoxIou : kTentativeBoxIou;
    std::optional<std::size_t> best;
    float best_iou = least;
    for (std::size_t i = 0; i < boxes_.size(); ++i) {
      const float iou = Iou(boxes_[i].box, object.visible_box);
      if (owners_[i] || boxes_[i].category != object.category || iou <= best_iou) continue;
      best = i;
      best_iou = iou;
    }
    if (best) owners_[*best] = object.id;
    return best.has_value();
  }

  void Live(MapObject& object) {
    if (!object.updated) return;
    const EdgeMatch match = MatchOf(object, m_.View(input_, occlusion_, object.id));
    object.phi_edge = static_cast<float>(match.Score());
    object.phi_cnn =
        LogScores(input_.detections.get(), object.category, {&match.whole_box, 1}).front();
    object.whole_box = match.whole_box;
    object.visible_box = match.visible_box;
    if (object.whole_box.area() > kFillsImage * ImageSize().area()) {
      m_.Retire(object, EventKind::kRetired, {}, "it would fill the image", report_);
    } else if (TooFewBoxes(object.paper, options())) {
      m_.Retire(object, EventKind::kRetired, {}, "in view without a box for too long", report_);
    } else if (object.state == ObjectState::kConfirmed) {
      if (Lost(match)) Unsettle(object);
    } else if (TooManyUpdates(object.paper, options())) {
      m_.Retire(object, EventKind::kRetired, {}, "tentative for too long", report_);
    } else if (Settles(object.paper, match, m_.map.database->model(object.mean().label))) {
      object.state = ObjectState::kConfirmed;
      object.confirmed_frame = input_.frame;
      report_.events.push_back({EventKind::kConfirmed, object.id, {}, "its pose has settled"});
    }
  }

  /// Back to where azimuth and label are searched for, from copies of the mean.
  void Unsettle(MapObject& object) {
    object.state = ObjectState::kTentative;
    object.confirmed_frame.reset();
    object.paper.Unsettle();
    const Particle mean =
        ToParticle(ToHypothesis(object.mean(), m_.map), object.world_from_reference_cam);
    object.particles.resize(std::max(CountOf(object), object.particles.size()), mean);
    object.memory.assign(object.particles.size(), 0.0f);
    for (Particle& particle : object.particles) particle.log_weight = 0;
    NormalizeLogWeights(object.particles);
  }

  /// Of two objects in one place the one that has settled stays, else the older one.
  void Merge() {
    const auto settled = [](const MapObject& object) {
      return object.state == ObjectState::kConfirmed;
    };
    for (std::size_t i = 0; i < m_.objects.size(); ++i) {
      for (std::size_t j = i + 1; j < m_.objects.size(); ++j) {
        MapObject &a = m_.objects[i], &b = m_.objects[j];
        if (a.state == ObjectState::kRetired || b.state == ObjectState::kRetired ||
            !Compete(a, b, m_.map)) {
          continue;
        }
        const bool second = settled(b) && !settled(a);
        MapObject &winner = second ? b : a, &loser = second ? a : b;
        m_.Retire(loser, EventKind::kMerged, winner.id,
                  "object " + std::to_string(winner.id.value) + " stands there", report_);
      }
    }
  }

  /// Covers the bounding rectangle of an object.
  static void Cover(const MapObject& object, cv::Mat& covered) {
    if (!object.whole_box.empty()) covered(PixelsOf(object.whole_box, covered.size())).setTo(1);
  }

  void Spawn() {
    cv::Mat covered = cv::Mat::zeros(ImageSize(), CV_8U);
    int tentative = 0, spawned = 0;
    for (const MapObject& object : m_.objects) {
      if (object.state == ObjectState::kRetired) continue;
      Cover(object, covered);
      tentative += object.state == ObjectState::kTentative ? 1 : 0;
    }
    const std::span<const Detection> detections =
        input_.detections ? input_.detections->proposals() : std::span<const Detection>{};
    std::size_t seen = 0;
    for (const Detection& detection : detections) {
      ProposalReport proposal{
          detection.box, detection.category, detection.score, ProposalFate::kLowScore, {}};
      const std::optional<ObjectId> owner = IsSeen(detection) ? owners_[seen++] : std::nullopt;
      const cv::Rect pixels = PixelsOf(detection.box, ImageSize());
      if (m_.map.database->OfCategory(detection.category).empty()) {
        proposal.fate = ProposalFate::kUnknownCategory;
      } else if (owner || cv::countNonZero(covered(pixels)) > kExplainedShare * pixels.area()) {
        proposal.fate = ProposalFate::kExplained;
        proposal.object = owner.value_or(Nearest(detection.box));
      } else if (IsSeen(detection) && tentative < m_.options().max_tentative &&
                 spawned < m_.options().max_spawns_per_frame) {
        proposal.fate = ProposalFate::kSpawned;
        proposal.object = Spawn(detection);
        Cover(m_.objects.back(), covered);
        ++tentative;
        ++spawned;
      }
      report_.proposals.push_back(std::move(proposal));
    }
  }

  /// Whose rectangle shares most with the box.
  ObjectId Nearest(const Box2& box) const {
    ObjectId nearest;
    float most = 0;
    for (const MapObject& object : m_.objects) {
      const float shared = Intersection(object.whole_box, box).area();
      if (object.state == ObjectState::kRetired || shared <= most) continue;
      nearest = object.id;
      most = shared;
    }
    return nearest;
  }

  /// A newborn object is updated at once, by the edges inside its box alone.
  ObjectId Spawn(const Detection& detection) {
    MapObject object;
    object.id = ObjectId{m_.next_object_id++};
    object.category = detection.category;
    object.reference_frame = object.first_frame = object.last_frame = input_.frame;
    object.world_from_reference_cam = input_.world_from_cam;
    object.particles =
        BirthAsPaper(detection.box, m_.setup.camera, m_.map.database->OfCategory(object.category),
                     options(), Key(m_.setup.seed, input_.frame, object.id, Draw::kBirth));
    const std::vector<NearestEdges> levels =
        SearchLevels(Inside(input_.edges, detection.box), options());
    UpdateParticles(object, Image(object, levels), object.particles.size());
    const EdgeMatch match = MatchOf(object, m_.View(input_, occlusion_, object.id));
    object.whole_box = match.whole_box;
    object.visible_box = match.visible_box;
    report_.events.push_back(
        {EventKind::kSpawned, object.id, {}, "an unexplained " + object.category + " box"});
    m_.objects.push_back(std::move(object));
    return m_.objects.back().id;
  }

  Impl& m_;
  const MapperInput& input_;
  double dt_s_;
  FrameReport& report_;
  OcclusionMaps occlusion_;
  std::vector<NearestEdges> levels_;
  std::vector<Detection> boxes_;                 ///< Those that are seen at all.
  std::vector<std::optional<ObjectId>> owners_;  ///< Of the boxes.
};

void Mapper::Impl::StepAsPaper(const MapperInput& input, double dt_s, FrameReport& report) {
  PaperStep(*this, input, dt_s, report).Run();
}

}  // namespace plumbline
