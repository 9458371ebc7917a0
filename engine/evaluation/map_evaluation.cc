// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/map_evaluation.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/evaluation/object_pairs.h"
#include "engine/evaluation/posed_scene.h"
#include "engine/evaluation/scene_alignment.h"

namespace plumbline {
namespace {

constexpr int kAlignmentRounds = 10;

class Evaluator {
 public:
  Evaluator(const CountedObjects& objects, std::span<const MovingThing> moving,
            const TriangleMesh* scan, const EvaluationOptions& options)
      : objects_(objects), moving_(moving), scan_(scan), options_(options) {}

  Result<MapEvaluation> Run() {
    PosedScene map;
    for (std::size_t i = 0; i < objects_.estimates.size(); ++i) {
      const EstimatedObject& estimate = objects_.estimates[i];
      map.Add(objects_.estimate_models[i]->mesh, estimate.world_from_object, estimate.scale,
              static_cast<int>(i));
    }
    SurfaceSamples samples;
    if (!map.mesh.triangles.empty()) {
      Result<SurfaceSamples> drawn = SampleSurface(map.mesh, options_.samples, options_.seed);
      if (!drawn) return drawn.error();
      samples = std::move(*drawn);
    }
    Result<std::unique_ptr<ClosestTriangleSearch>> surface = BuildTruthSurface();
    if (!surface) return surface.error();

    Align(samples.points, **surface);
    for (Eigen::Vector3d& point : samples.points) point = evaluation_.truth_from_estimate * point;
    MeasureSurface(map, samples, **surface);
    MatchAndCompare();
    if (const Status measured = MeasureCompleteness(); !measured.ok()) return measured.error();
    return std::move(evaluation_);
  }

 private:
  /// Instances matched to the estimates, under the alignment so far.
  std::vector<std::optional<int>> Match() const {
    return PairObjects(objects_, evaluation_.truth_from_estimate, options_.match_distance_m);
  }

  void Align(const std::vector<Eigen::Vector3d>& samples, const ClosestTriangleSearch& surface) {
    if (options_.align == Alignment::kNone) return;
    const Eigen::Isometry3d& given = options_.truth_from_estimate;
    evaluation_.truth_from_estimate = given;
    if (options_.align == Alignment::kTrajectory) return;
    if (options_.align == Alignment::kObjects) return AlignObjects();
    const std::size_t count = std::min<std::size_t>(samples.size(), kIcpSamples);
    std::vector<Eigen::Vector3d> points(samples.begin(),
                                        samples.begin() + static_cast<std::ptrdiff_t>(count));
    for (Eigen::Vector3d& point : points) point = given * point;
    const std::optional<Eigen::Vector3d> up =
        options_.align == Alignment::kIcp4 ? std::optional(up_in_world()) : std::nullopt;
    evaluation_.truth_from_estimate = AlignToSurface(points, surface, up) * given;
  }

  /// Matching and aligning depend on one another: in turns, until the pairs stay.
  void AlignObjects() {
    std::vector<std::optional<int>> before;
    for (int round = 0; round < kAlignmentRounds; ++round) {
      const std::vector<std::optional<int>> pairs = Match();
      if (pairs == before) return;
      before = pairs;
      std::vector<Eigen::Vector3d> from, to;
      for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (!pairs[i]) continue;
        const auto truth = static_cast<std::size_t>(*pairs[i]);
        from.push_back(options_.truth_from_estimate *
                       objects_.estimates[i].world_from_object.translation());
        to.push_back(objects_.truths[truth].world_from_object.translation());
      }
      evaluation_.truth_from_estimate =
          FitYawAndTranslation(from, to, up_in_world()) * options_.truth_from_estimate;
    }
  }

  Result<std::unique_ptr<ClosestTriangleSearch>> BuildTruthSurface() const {
    PosedScene scene;
    if (options_.truth != TruthSurface::kModels && scan_ != nullptr) {
      scene.Add(*scan_, Eigen::Isometry3d::Identity(), 1, -1);
    }
    if (options_.truth != TruthSurface::kScan) {
      for (const PosedModel& posed : objects_.posed_truth)
        scene.Add(posed.model->mesh, posed.scene_from_object, posed.scale, -1);
    } else if (scan_ == nullptr) {
      return Error{ErrorCode::kInvalidInput,
                   "the scan alone shall be the truth, but none is given; add --scene FILE.ply"};
    }
    if (scene.mesh.triangles.empty()) {
      return Error{ErrorCode::kDegenerate,
                   "the true surface has no triangles; give a scan that is a mesh, or ground truth "
                   "with instances"};
    }
    return ClosestTriangleSearch::Build(scene.mesh);
  }

  void MeasureSurface(const PosedScene& map, const SurfaceSamples& samples,
                      const ClosestTriangleSearch& surface) {
    SurfaceDistances distances = MeasureDistances(samples.points, surface);
    std::vector<std::vector<double>> by_object(objects_.estimates.size());
    for (std::size_t i = 0; i < samples.triangles.size(); ++i) {
      const int object = map.object_of_triangle[static_cast<std::size_t>(samples.triangles[i])];
      by_object[static_cast<std::size_t>(object)].push_back(distances.to_triangle_m[i]);
    }
    for (std::vector<double>& of_object : by_object)
      surface_of_estimate_.push_back(Statistics(std::move(of_object)));
    evaluation_.surface = Statistics(std::move(distances.to_triangle_m));
    evaluation_.surface_normal = Statistics(std::move(distances.to_plane_m));
  }

  void MatchAndCompare() {
    const std::vector<std::optional<int>> pairs = Match();
    std::vector<bool> found(objects_.truths.size(), false);
    for (std::size_t i = 0; i < objects_.estimates.size(); ++i) {
      if (!pairs[i]) {
        evaluation_.spurious.push_back(
            {objects_.estimates[i], surface_of_estimate_[i], MovingAt(objects_.estimates[i])});
        continue;
      }
      const auto truth = static_cast<std::size_t>(*pairs[i]);
      found[truth] = true;
      MatchedObject& matched = evaluation_.matched.emplace_back(
          CompareObject(objects_, evaluation_.truth_from_estimate, i, truth));
      matched.surface = surface_of_estimate_[i];
    }
    for (std::size_t j = 0; j < objects_.truths.size(); ++j) {
      if (!found[j]) evaluation_.missed.push_back(objects_.truths[j]);
    }
    evaluation_.mean = MeanOf(evaluation_.matched, true);
    evaluation_.mean_all = MeanOf(evaluation_.matched, false);
  }

  /// The moving thing whose base, seen from above, holds the origin of an estimate at some time.
  std::string MovingAt(const EstimatedObject& estimate) const {
    const Eigen::Vector3d origin =
        evaluation_.truth_from_estimate * estimate.world_from_object.translation();
    for (const MovingThing& thing : moving_) {
      if (thing.category != estimate.category) continue;
      for (const MovingThing::Place& place : thing.places) {
        const Eigen::Vector3d there = place.world_from_object.inverse() * origin;
        if (std::abs(there.x()) <= thing.size_m.x() / 2 &&
            std::abs(there.y()) <= thing.size_m.y() / 2)
          return thing.id;
      }
    }
    return {};
  }

  /// The walls of a scan are nothing that a map of objects could contain: from the true objects
  /// only.
  Status MeasureCompleteness() {
    PosedScene objects, map;
    for (std::size_t i = 0; i < objects_.truths.size(); ++i) {
      const GroundTruthInstance& truth = objects_.truths[i];
      objects.Add(objects_.truth_models[i]->mesh, truth.world_from_object, truth.scale,
                  static_cast<int>(i));
    }
    for (std::size_t i = 0; i < objects_.estimates.size(); ++i) {
      const EstimatedObject& estimate = objects_.estimates[i];
      map.Add(objects_.estimate_models[i]->mesh,
              evaluation_.truth_from_estimate * estimate.world_from_object, estimate.scale,
              static_cast<int>(i));
    }
    if (objects.mesh.triangles.empty() || map.mesh.triangles.empty()) return {};
    const Result<SurfaceSamples> samples =
        SampleSurface(objects.mesh, options_.samples, options_.seed);
    if (!samples) return samples.error();
    const Result<std::unique_ptr<ClosestTriangleSearch>> surface =
        ClosestTriangleSearch::Build(map.mesh);
    if (!surface) return surface.error();
    evaluation_.completeness =
        Statistics(MeasureDistances(samples->points, **surface).to_triangle_m);
    return {};
  }

  const Eigen::Vector3d& up_in_world() const { return objects_.upright.up_in_world(); }

  const CountedObjects& objects_;
  std::span<const MovingThing> moving_;
  const TriangleMesh* scan_;
  const EvaluationOptions& options_;
  std::vector<ErrorStatistics> surface_of_estimate_;
  MapEvaluation evaluation_;
};

}  // namespace

Result<MapEvaluation> EvaluateMap(std::span<const EstimatedObject> estimates,
                                  const GroundTruth& truth, const ModelDatabase& database,
                                  const TriangleMesh* scan, const EvaluationOptions& options) {
  PLB_CHECK(options.samples > 0) << options.samples;
  const Result<CountedObjects> objects =
      CollectObjects(estimates, truth, database, options.ignored_categories);
  if (!objects) return objects.error();
  return Evaluator(*objects, truth.moving, scan, options).Run();
}

}  // namespace plumbline
