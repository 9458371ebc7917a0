// SPDX-License-Identifier: Apache-2.0
#include "engine/smoothing/smoother.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "engine/mapping/association.h"
#include "engine/mapping/judging.h"
#include "engine/smoothing/joint_solution.h"
#include "engine/smoothing/object_views.h"
#include "engine/smoothing/object_work.h"
#include "engine/smoothing/resampling.h"
#include "engine/smoothing/scene_refiner.h"

namespace plumbline {
namespace {

constexpr int kSampledViews = 20;
constexpr int kSweeps = 2;
// Withdrawn objects that are given another chance: so many, with log odds of at least so much.
constexpr std::size_t kMostWithdrawn = 24;
constexpr double kLittleAgainst = -3;
constexpr double kInOnePlace_m = 0.08;  ///< What stands so deep in a settled object is not there.

/// Log odds beyond the filter's rule: what is confirmed here is the best of many that were looked
/// at again, which alone raises it.
constexpr double kSelectionMargin = 3.2;

Error Cancelled() { return {ErrorCode::kCancelled, "smoothing was cancelled"}; }

/// The second pass takes the scale of each object from the run.
MapperSetup WithScalesFixed(MapperSetup setup) {
  setup.options.scale_std = 0;
  return setup;
}

class Smoother {
 public:
  Smoother(const SmoothingTask& task, const WorkContext& work)
      : task_(task),
        setup_(WithScalesFixed(task.setup)),
        map_(MapFrameOf(setup_)),
        renderer_(*task.setup.database),
        work_(work) {}

  Result<SmoothedMap> Run() {
    looks_ = ChooseLooks(task_.frames, setup_.camera, setup_.options);
    if (Status status = Gather(); !status.ok()) return status.error();
    if (Status status = FindViews(); !status.ok()) return status.error();
    if (Status status = ResampleAll(0); !status.ok()) return status.error();
    auto presences = LookBack(setup_, renderer_, looks_, Objects(), task_.load, work_);
    if (!presences.ok()) return presences.error();
    for (std::size_t i = 0; i < items_.size(); ++i) items_[i].presence = std::move((*presences)[i]);
    Select();
    for (int sweep = 1; sweep <= kSweeps; ++sweep) {
      if (Status status = FindViews(); !status.ok()) return status.error();
      if (Status status = Sweep(sweep); !status.ok()) return status.error();
    }
    return Conclude();
  }

 private:
  // Gathering -------------------------------------------------------------------------------

  /// All objects of the end, and of the withdrawn ones those that most speaks for.
  Status Gather() {
    std::vector<const ObjectReport*> reports, withdrawn;
    for (const ObjectReport& report : task_.objects) {
      const bool gone = report.state == ObjectState::kRetired;
      if (!gone) reports.push_back(&report);
      if (gone && report.log_evidence > kLittleAgainst) withdrawn.push_back(&report);
    }
    std::stable_sort(withdrawn.begin(), withdrawn.end(), [](const auto* a, const auto* b) {
      return a->log_evidence > b->log_evidence;
    });
    withdrawn.resize(std::min(withdrawn.size(), kMostWithdrawn));
    reports.insert(reports.end(), withdrawn.begin(), withdrawn.end());
    std::sort(reports.begin(), reports.end(),
              [](const auto* a, const auto* b) { return a->id < b->id; });
    for (const ObjectReport* report : reports) {
      Result<MapObject> object = FromReport(*report, *map_.database);
      if (!object.ok()) return object.error();
      if (object->state == ObjectState::kRetired) object->state = ObjectState::kTentative;
      for (Particle& particle : object->particles)
        particle.log_scale = static_cast<float>(std::log(object->scale));
      items_.push_back({.causal = *report, .object = std::move(object).value()});
      Believe(items_.back());
    }
    return {};
  }

  std::vector<MapObject> Objects() const {
    std::vector<MapObject> objects;
    for (const ObjectWork& item : items_) objects.push_back(item.object);
    return objects;
  }

  /// What was sampled is the best that is known.
  void Believe(ObjectWork& item) const {
    item.pose = ToHypothesis(item.object.mean(), map_);
    item.covariance = item.object.covariance;
    item.refined.reset();
  }

  Status FindViews() {
    const std::vector<MapObject> objects = Objects();
    std::vector<std::vector<ObjectSight>> sights = FindSights(setup_, renderer_, looks_, objects);
    std::set<int> wanted;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      items_[i].sights = std::move(sights[i]);
      items_[i].views = ChooseViews(items_[i].sights, kSampledViews);
      for (const std::size_t view : items_[i].views) wanted.insert(items_[i].sights[view].frame);
    }
    int done = 0;
    for (const int frame : wanted) {
      if (work_.stop.stop_requested()) return Cancelled();
      work_.report({"reading views", ++done, static_cast<int>(wanted.size())});
      if (inputs_.contains(frame)) continue;
      Result<MapperInput> input = task_.load(frame);
      if (!input.ok()) continue;  // as the run itself leaves such a frame out
      input->table.reset();       // one for each object follows, of the edges that are left for it
      inputs_.emplace(frame, std::move(input).value());
    }
    return {};
  }

  // Sampling --------------------------------------------------------------------------------

  Status ResampleAll(int round) {
    for (std::size_t i = 0; i < items_.size(); ++i) {
      if (work_.stop.stop_requested()) return Cancelled();
      ResampleObject(items_[i], round);
      work_.report({"sampling", static_cast<int>(i + 1), static_cast<int>(items_.size())});
    }
    return {};
  }

  void ResampleObject(ObjectWork& item, int round) {
    std::vector<ObjectImage> images;
    for (const std::size_t view : item.views) {
      const auto input = inputs_.find(item.sights[view].frame);
      if (input == inputs_.end()) continue;
      ObjectImage image;
      const bool afar =
          IsAfar(map_, item.pose, input->second.world_from_cam.inverse(), setup_.options);
      image.table = std::make_shared<const OrientedTable>(
          refiner_.EdgesFor(item, input->first),
          afar ? NarrowSearchOptions(setup_.options, setup_.camera.fx)
               : SearchOptions(setup_.options, setup_.camera.fx));
      image.detections = input->second.detections;
      const OcclusionMaps maps = renderer_.RenderOccluders(
          setup_.camera, input->second.world_from_cam.inverse(), MeanStates(Objects(), true));
      image.judging.view =
          ViewOf(setup_, input->second.world_from_cam, maps, item.object.id, *image.table);
      image.judging.detections = image.detections.get();
      image.judging.weight = item.sights[view].telling;
      HypothesisScore score;
      setup_.scorer->Score(image.judging.view, map_.upright, {&item.pose, 1}, {&score, 1});
      image.judging.normalizer = EdgeNormalizer({&score, 1});
      images.push_back(std::move(image));
    }
    const RandomKey key{
        setup_.seed, static_cast<std::uint32_t>(task_.frames.back().frame + 1),
        static_cast<std::uint32_t>(item.object.id.value) * 8 + static_cast<std::uint32_t>(round),
        0};
    Resample(*setup_.scorer, map_, images, setup_.options, key, item.object);
    Believe(item);
  }

  // Being there -----------------------------------------------------------------------------

  /// Who is there: what the run has confirmed stays unless all looks together speak against it;
  /// others are confirmed by the filter's own rule with a margin, where nothing of their kind and
  /// nothing solid stands.
  void Select() {
    const MapperOptions& options = setup_.options;
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < items_.size(); ++i) order.push_back(i);
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      const auto rank = [&](std::size_t k) {
        return std::pair(items_[k].object.state == ObjectState::kConfirmed,
                         items_[k].presence.log_odds);
      };
      return rank(a) > rank(b);
    });
    std::vector<std::size_t> kept;
    for (const std::size_t i : order) {
      ObjectWork& item = items_[i];
      const bool confirmed = item.object.state == ObjectState::kConfirmed;
      const double odds = item.presence.log_odds;
      item.kept = confirmed ? odds > options.retire_evidence
                            : odds > options.confirm_evidence + kSelectionMargin &&
                                  item.presence.shown >= 1 &&
                                  item.object.mean().position_std_m <
                                      map_.LeastKnown(item.object.mean().label, options) &&
                                  BeliefInMean(item.object, map_) >= options.confirm_mode_weight;
      item.kept = item.kept && std::none_of(kept.begin(), kept.end(), [&](std::size_t other) {
                    return InPlaceOf(item, items_[other], other);
                  });
      item.object.state = item.kept ? ObjectState::kConfirmed : ObjectState::kTentative;
      if (item.kept) kept.push_back(i);
    }
  }

  /// Whether an object cannot be there because `other` is.
  bool InPlaceOf(ObjectWork& item, const ObjectWork& other, std::size_t index) {
    MapObject a = item.object, b = other.object;
    a.updated = b.updated = false;  // footprints alone; boxes are compared over all looks
    if (Compete(a, b, map_)) return true;
    const auto looks =
        static_cast<double>(std::min(item.presence.frames.size(), other.presence.frames.size()));
    if (a.category == b.category && item.presence.same_view[index] > 0.5 * looks) return true;
    if (other.causal.state != ObjectState::kConfirmed ||
        item.causal.state == ObjectState::kConfirmed)
      return false;
    const PoseMode& settled = other.object.mean();
    if (a.category == b.category &&
        PlaceOf(map_.database->model(settled.label), settled.world_from_object, settled.scale)
            .Holds(item.pose.center_in_world))
      return true;
    const auto of_a = refiner_.Solid(item.pose), of_b = refiner_.Solid(other.pose);
    if (of_a == nullptr || of_b == nullptr) return false;
    const auto contact = FindContact(*of_a, map_.WorldFromObject(item.pose), *of_b,
                                     map_.WorldFromObject(other.pose));
    return contact && contact->depth_m > kInOnePlace_m;
  }

  // Refinement ------------------------------------------------------------------------------

  /// Every object anew, with the others where the last sweep left them.
  Status Sweep(int sweep) {
    refiner_.Claim(items_);
    int done = 0, all = 0;
    for (const ObjectWork& item : items_) all += item.kept ? 1 : 0;
    for (ObjectWork& item : items_) {
      if (!item.kept) continue;
      if (work_.stop.stop_requested()) return Cancelled();
      const Occluders occluders = refiner_.OccludersOf(items_, item);
      ResampleObject(item, sweep);
      if (!refiner_.Refine(item, occluders, work_.stop).ok()) return Cancelled();
      work_.report({"refining together", (sweep - 1) * all + ++done, kSweeps * all});
    }
    return {};
  }

  // Together --------------------------------------------------------------------------------

  SmoothedMap Conclude() {
    std::vector<ObjectWork*> kept;
    std::vector<MeasuredObject> measured;
    for (ObjectWork& item : items_) {
      if (!item.kept) continue;
      kept.push_back(&item);
      const bool stands = setup_.options.floor_prior && item.refined &&
                          setup_.database->model(item.pose.label).support == Support::kFloor;
      measured.push_back({item.pose, item.covariance, refiner_.Solid(item.pose), stands});
    }
    const JointSolution together = SolveJointly(measured, map_, setup_.options);
    SmoothedMap result;
    result.last_frame = task_.frames.back().frame;
    result.looks = static_cast<int>(looks_.size());
    result.floor_objects = together.floor_objects;
    result.floor_height_m = together.floor_height_m;
    result.floor_std_m = together.floor_std_m;
    std::map<int, double> pushed;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      pushed[kept[i]->object.id.value] =
          (together.poses[i].center_in_world - kept[i]->pose.center_in_world).norm();
      kept[i]->pose = together.poses[i];
      kept[i]->covariance = together.covariances[i];
    }
    for (const ObjectWork& item : items_) {
      const bool gone = item.causal.state == ObjectState::kRetired;
      if (gone && !item.kept) continue;
      result.objects.push_back(Describe(item));
      result.objects.back().pushed_m = pushed[item.object.id.value];
    }
    return result;
  }

  SmoothedObject Describe(const ObjectWork& item) const {
    SmoothedObject smoothed;
    ObjectReport& belief = smoothed.belief;
    static_cast<ObjectBelief&>(belief) = item.object;
    belief.log_evidence = item.presence.log_odds;
    belief.covariance = item.covariance;
    belief.updated = true;
    belief.world_from_object = map_.WorldFromObject(item.pose);
    belief.scale = item.pose.scale();
    belief.scale_std = item.causal.scale_std;
    PoseMode& mean = belief.modes.front();
    mean.scale = belief.scale;
    mean.scale_std = belief.scale_std;
    mean.world_from_object = belief.world_from_object;
    mean.position_std_m = std::sqrt(item.covariance.topLeftCorner<3, 3>().trace());
    mean.azimuth_std_rad = std::sqrt(item.covariance(3, 3));
    const std::vector<int>& frames = item.presence.frames;
    smoothed.spawned_frame = item.causal.first_frame;
    smoothed.looks = static_cast<int>(frames.size());
    smoothed.looks_before = static_cast<int>(
        std::lower_bound(frames.begin(), frames.end(), item.causal.first_frame) - frames.begin());
    if (!frames.empty()) belief.first_frame = std::min(frames.front(), item.causal.first_frame);
    smoothed.refined = item.refined.has_value();
    smoothed.views = item.refined ? item.refined->images : static_cast<int>(item.views.size());
    smoothed.agreement = item.refined ? item.refined->agreement_after : 0;
    return smoothed;
  }

  const SmoothingTask& task_;
  MapperSetup setup_;
  MapFrame map_;
  OcclusionRenderer renderer_;
  const WorkContext& work_;
  std::vector<Look> looks_;
  std::vector<ObjectWork> items_;
  FrameInputs inputs_;
  SceneRefiner refiner_{setup_, map_, inputs_};
};

}  // namespace

Result<SmoothedMap> Smooth(const SmoothingTask& task, const WorkContext& work) {
  if (task.frames.empty())
    return Error{ErrorCode::kInvalidInput, "a run that used no frame cannot be smoothed"};
  return Smoother(task, work).Run();
}

}  // namespace plumbline
