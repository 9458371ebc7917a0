// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/surface_references.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/evaluation/object_pairs.h"
#include "engine/evaluation/posed_scene.h"
#include "engine/evaluation/scanned_surface.h"
#include "engine/evaluation/scene_alignment.h"

namespace plumbline {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// `max_distance` of the configuration that VISMA publishes.
constexpr double kVismaReach_m = 0.075;

Points Moved(Points points, const Eigen::Isometry3d& target_from_points) {
  for (Eigen::Vector3d& point : points) point = target_from_points * point;
  return points;
}

SurfaceDistance Summed(SurfaceDistances distances) {
  return {Statistics(std::move(distances.to_triangle_m)),
          Statistics(std::move(distances.to_plane_m))};
}

/// The turn of the true model, among those in which it looks the same, that is nearest to the
/// estimate.
Eigen::Isometry3d NearestTurn(const Eigen::Matrix3d& estimate, const Eigen::Matrix3d& truth,
                              const Symmetry& symmetry) {
  const Eigen::Vector3d axis = symmetry.axis.normalized();
  const Eigen::Matrix3d from_truth = estimate.transpose() * truth;
  // trace(M exp(a [n]x)) = cos(a) (tr M - n.Mn) + sin(a) sum_i n_i (M_kj - M_jk) + const.
  const Eigen::Vector3d skew(from_truth(1, 2) - from_truth(2, 1),
                             from_truth(2, 0) - from_truth(0, 2),
                             from_truth(0, 1) - from_truth(1, 0));
  const double best = std::atan2(axis.dot(skew), from_truth.trace() - axis.dot(from_truth * axis));
  double turn = best;
  if (symmetry.order > 0) {
    const double step = 2 * std::numbers::pi / symmetry.order;
    turn = step * std::round(best / step);
  }
  return Eigen::Isometry3d(Eigen::AngleAxisd(turn, axis));
}

/// Where on the true object each point of an estimate would lie if the estimate stood right.
class Counterparts {
 public:
  Counterparts(const CountedObjects& objects, const Eigen::Isometry3d& truth_from_estimate,
               double reach_m)
      : pairs_(PairObjects(objects, truth_from_estimate, reach_m)) {
    for (std::size_t i = 0; i < pairs_.size(); ++i) {
      truth_from_map_.push_back(Eigen::Affine3d::Identity());
      same_model_.push_back(false);
      if (!pairs_[i]) continue;
      const auto at = static_cast<std::size_t>(*pairs_[i]);
      const EstimatedObject& estimate = objects.estimates[i];
      const GroundTruthInstance& truth = objects.truths[at];
      const Eigen::Isometry3d turn =
          NearestTurn((truth_from_estimate * estimate.world_from_object).linear(),
                      truth.world_from_object.linear(), objects.truth_models[at]->symmetry);
      same_model_.back() = objects.estimate_models[i] == objects.truth_models[at];
      // Another model stands at the same place in its own size.
      const double scale = same_model_.back() ? truth.scale / estimate.scale : 1.0;
      truth_from_map_.back() = truth.world_from_object * turn * Eigen::Scaling(scale) *
                               estimate.world_from_object.inverse();
    }
  }

  bool IsMatched(int estimate) const {
    return pairs_[static_cast<std::size_t>(estimate)].has_value();
  }

  /// @param point  In the frame of the map, on the surface of a matched estimate.
  Eigen::Vector3d Of(const Eigen::Vector3d& point, int estimate,
                     const ScannedSurface& scanned) const {
    const auto at = static_cast<std::size_t>(estimate);
    const Eigen::Vector3d moved = truth_from_map_[at] * point;
    return same_model_[at] ? moved : scanned.Nearest(moved);
  }

 private:
  std::vector<std::optional<int>> pairs_;
  std::vector<Eigen::Affine3d> truth_from_map_;
  std::vector<bool> same_model_;
};

class References {
 public:
  References(const CountedObjects& objects, const Eigen::Isometry3d& truth_from_estimate,
             const EvaluationOptions& options)
      : objects_(objects), truth_from_estimate_(truth_from_estimate), options_(options) {}

  Status Draw() {
    for (std::size_t i = 0; i < objects_.estimates.size(); ++i) {
      const EstimatedObject& estimate = objects_.estimates[i];
      map_.Add(objects_.estimate_models[i]->mesh, estimate.world_from_object, estimate.scale,
               static_cast<int>(i));
    }
    if (map_.mesh.triangles.empty()) return {};
    Result<SurfaceSamples> drawn = SampleSurface(map_.mesh, options_.samples, options_.seed);
    if (!drawn) return drawn.error();
    samples_ = std::move(*drawn);
    moved_ = Moved(samples_.points, truth_from_estimate_);
    return {};
  }

  Status ToPosedTruth() {
    PosedScene scene;
    for (const PosedModel& posed : objects_.posed_truth)
      scene.Add(posed.model->mesh, posed.scene_from_object, posed.scale, 0);
    if (scene.mesh.triangles.empty()) return {};  // a scene in which nothing is annotated
    auto surface = ClosestTriangleSearch::Build(scene.mesh);
    if (!surface) return surface.error();
    posed_ = std::move(*surface);
    references_.posed = Summed(MeasureDistances(moved_, *posed_));
    return {};
  }

  Status ToScan(const TriangleMesh& scan) {
    auto surface = ClosestTriangleSearch::Build(scan);
    if (!surface) return surface.error();
    if (const Status done = Scanned(scan, **surface); !done.ok()) return done;
    Points some = moved_;
    some.resize(std::min(some.size(), kIcpSamples));
    ByThePaper(some, **surface);
    if (posed_ == nullptr) return {};
    const Eigen::Isometry3d icp =
        AlignToSurface(some, **surface, std::nullopt, {.max_distance_m = kVismaReach_m});
    references_.visma = Summed(MeasureDistances(Moved(moved_, icp), *posed_));
    return {};
  }

  SurfaceReferences Take() { return std::move(references_); }

 private:
  Status Scanned(const TriangleMesh& scan, const ClosestTriangleSearch& surface) {
    if (posed_ == nullptr) return {};
    const Result<ScannedSurface> scanned = ScannedSurface::Build(scan, objects_.posed_truth);
    if (!scanned) return scanned.error();
    const Counterparts counterparts(objects_, truth_from_estimate_, options_.match_distance_m);
    Points judged;
    int of_matched = 0, was_scanned = 0;
    for (std::size_t i = 0; i < moved_.size(); ++i) {
      const int object = map_.object_of_triangle[static_cast<std::size_t>(samples_.triangles[i])];
      const bool matched = counterparts.IsMatched(object);
      of_matched += matched;
      if (matched && !scanned->At(counterparts.Of(samples_.points[i], object, *scanned))) continue;
      was_scanned += matched;
      judged.push_back(moved_[i]);
    }
    const double share = of_matched > 0 ? static_cast<double>(was_scanned) / of_matched : 0;
    references_.scanned = {Summed(MeasureDistances(judged, surface)), share};
    return {};
  }

  void ByThePaper(const Points& some, const ClosestTriangleSearch& surface) {
    const Eigen::Isometry3d icp = AlignToSurface(some, surface, std::nullopt);
    // The value is given for clang, to which a nested struct seems to have no default constructor.
    SurfaceReferences::Paper& paper = references_.paper.emplace(SurfaceReferences::Paper());
    paper.distance = Summed(MeasureDistances(Moved(moved_, icp), surface));
    paper.truth_from_estimate = icp * truth_from_estimate_;
    const auto pairs = PairObjects(objects_, paper.truth_from_estimate, options_.match_distance_m);
    std::vector<MatchedObject> matched;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (!pairs[i]) continue;
      matched.push_back(CompareObject(objects_, paper.truth_from_estimate, i,
                                      static_cast<std::size_t>(*pairs[i])));
    }
    paper.matched = static_cast<int>(matched.size());
    paper.mean = MeanOf(matched, true);
    paper.mean_all = MeanOf(matched, false);
  }

  const CountedObjects& objects_;
  const Eigen::Isometry3d truth_from_estimate_;
  const EvaluationOptions& options_;
  PosedScene map_;
  SurfaceSamples samples_;  ///< In the frame of the map.
  Points moved_;            ///< The same in that of the truth.
  std::unique_ptr<ClosestTriangleSearch> posed_;
  SurfaceReferences references_;
};

}  // namespace

Result<SurfaceReferences> CompareSurfaces(std::span<const EstimatedObject> estimates,
                                          const GroundTruth& truth, const ModelDatabase& database,
                                          const TriangleMesh* scan, const MapEvaluation& evaluation,
                                          const EvaluationOptions& options) {
  const Result<CountedObjects> objects =
      CollectObjects(estimates, truth, database, options.ignored_categories);
  if (!objects) return objects.error();
  References references(*objects, evaluation.truth_from_estimate, options);
  if (const Status done = references.Draw(); !done.ok()) return done.error();
  if (const Status done = references.ToPosedTruth(); !done.ok()) return done.error();
  if (scan != nullptr) {
    if (const Status done = references.ToScan(*scan); !done.ok()) return done.error();
  }
  return references.Take();
}

}  // namespace plumbline
