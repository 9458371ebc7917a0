// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/map_evaluation.h"

#include <algorithm>
#include <tuple>

#include "engine/base/check.h"
#include "engine/evaluation/scene_alignment.h"
#include "engine/evaluation/truth_pairing.h"

namespace plumbline {
namespace {

constexpr int kAlignmentSamples = 20'000;
constexpr int kAlignmentRounds = 10;

/// Posed meshes as one, and which object each triangle belongs to.
struct PosedScene {
  TriangleMesh mesh;
  std::vector<int> object_of_triangle;

  void Add(const TriangleMesh& model, const Eigen::Isometry3d& scene_from_object, double scale,
           int object) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const Eigen::Vector3f& vertex : model.vertices) {
      mesh.vertices.push_back((scene_from_object * (scale * vertex.cast<double>())).cast<float>());
    }
    for (const Eigen::Vector3i& triangle : model.triangles) {
      mesh.triangles.push_back(triangle.array() + first);
      object_of_triangle.push_back(object);
    }
  }
};

/// Everything that counts, with its models found.
class Evaluator {
 public:
  Evaluator(const Eigen::Vector3d& gravity, const TriangleMesh* scan,
            const EvaluationOptions& options)
      : scan_(scan), options_(options), upright_(gravity) {}

  Status Collect(std::span<const EstimatedObject> estimates, const GroundTruth& all_truth,
                 const ModelDatabase& database) {
    for (const GroundTruthInstance& instance : all_truth.instances) {
      const Result<const CadModel*> model =
          FindModel(database, instance.model, "ground truth instance " + instance.id);
      const bool ignored = Ignored(instance.category);
      if (!model && !ignored) return model.error();
      if (model) surface_truth_.push_back({instance.world_from_object, instance.scale, *model});
      if (ignored) continue;
      truth_.push_back(instance);
      truth_models_.push_back(*model);
    }
    for (const EstimatedObject& estimate : estimates) {
      if (Ignored(estimate.category)) continue;
      const Result<const CadModel*> model =
          FindModel(database, estimate.model, "object " + estimate.id);
      if (!model) return model.error();
      estimates_.push_back(estimate);
      estimate_models_.push_back(*model);
    }
    return {};
  }

  Result<MapEvaluation> Run() {
    PosedScene map;
    for (std::size_t i = 0; i < estimates_.size(); ++i) {
      map.Add(estimate_models_[i]->mesh, estimates_[i].world_from_object, estimates_[i].scale,
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
  bool Ignored(const std::string& category) const {
    const std::vector<std::string>& ignored = options_.ignored_categories;
    return std::find(ignored.begin(), ignored.end(), category) != ignored.end();
  }

  static Result<const CadModel*> FindModel(const ModelDatabase& database, const std::string& name,
                                           const std::string& who) {
    const std::optional<ModelId> id = database.Find(name);
    if (!id) {
      return Error{ErrorCode::kNotFound, who + " is of the model '" + name + "', which " +
                                             (database.folder() / "models.json").string() +
                                             " does not have; give the database of that run"};
    }
    return &database.model(*id);
  }

  Eigen::Isometry3d AlignedPose(std::size_t estimate) const {
    return evaluation_.truth_from_estimate * estimates_[estimate].world_from_object;
  }

  /// Instances matched to the estimates, under the alignment so far.
  std::vector<std::optional<int>> Match() const {
    std::vector<PlacedThing> estimates, truths;
    for (std::size_t i = 0; i < estimates_.size(); ++i)
      estimates.push_back({estimates_[i].category, AlignedPose(i).translation()});
    for (const GroundTruthInstance& instance : truth_)
      truths.push_back({instance.category, instance.world_from_object.translation()});
    return PairWithTruth(estimates, truths, options_.match_distance_m);
  }

  void Align(const std::vector<Eigen::Vector3d>& samples, const ClosestTriangleSearch& surface) {
    if (options_.align == Alignment::kNone) return;
    const Eigen::Isometry3d& given = options_.truth_from_estimate;
    evaluation_.truth_from_estimate = given;
    if (options_.align == Alignment::kTrajectory) return;
    if (options_.align == Alignment::kObjects) return AlignObjects();
    const std::size_t count = std::min<std::size_t>(samples.size(), kAlignmentSamples);
    std::vector<Eigen::Vector3d> points(samples.begin(),
                                        samples.begin() + static_cast<std::ptrdiff_t>(count));
    for (Eigen::Vector3d& point : points) point = given * point;
    const std::optional<Eigen::Vector3d> up =
        options_.align == Alignment::kIcp4 ? std::optional(upright_.up_in_world()) : std::nullopt;
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
        from.push_back(options_.truth_from_estimate *
                       estimates_[i].world_from_object.translation());
        to.push_back(truth_[static_cast<std::size_t>(*pairs[i])].world_from_object.translation());
      }
      evaluation_.truth_from_estimate =
          FitYawAndTranslation(from, to, upright_.up_in_world()) * options_.truth_from_estimate;
    }
  }

  Result<std::unique_ptr<ClosestTriangleSearch>> BuildTruthSurface() const {
    PosedScene scene;
    if (options_.truth != TruthSurface::kModels && scan_ != nullptr) {
      scene.Add(*scan_, Eigen::Isometry3d::Identity(), 1, -1);
    }
    if (options_.truth != TruthSurface::kScan) {
      for (const auto& [world_from_object, scale, model] : surface_truth_) {
        scene.Add(model->mesh, world_from_object, scale, -1);
      }
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
    std::vector<std::vector<double>> by_object(estimates_.size());
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
    std::vector<bool> found(truth_.size(), false);
    for (std::size_t i = 0; i < estimates_.size(); ++i) {
      if (!pairs[i]) {
        evaluation_.spurious.push_back({estimates_[i], surface_of_estimate_[i]});
        continue;
      }
      found[static_cast<std::size_t>(*pairs[i])] = true;
      evaluation_.matched.push_back(Compare(i, static_cast<std::size_t>(*pairs[i])));
    }
    for (std::size_t j = 0; j < truth_.size(); ++j) {
      if (!found[j]) evaluation_.missed.push_back(truth_[j]);
    }
    evaluation_.mean = MeanOf(true);
    evaluation_.mean_all = MeanOf(false);
  }

  MatchedObject Compare(std::size_t estimate, std::size_t instance) const {
    const CadModel& true_model = *truth_models_[instance];
    const Eigen::Isometry3d pose = AlignedPose(estimate);
    MatchedObject object;
    object.estimate = estimates_[estimate];
    object.truth = truth_[instance];
    object.model_correct = object.estimate.model == object.truth.model;
    object.continuous_symmetry = true_model.symmetry.order == 0;
    object.pose = ComparePoses(pose, object.truth.world_from_object, true_model.symmetry, upright_);
    object.centre_m = (pose * (object.estimate.scale * estimate_models_[estimate]->center()) -
                       object.truth.world_from_object * (object.truth.scale * true_model.center()))
                          .norm();
    object.surface = surface_of_estimate_[estimate];
    return object;
  }

  MeanPoseError MeanOf(bool fine_only) const {
    double translation = 0, rotation = 0;
    int translations = 0, rotations = 0;
    for (const MatchedObject& object : evaluation_.matched) {
      if (fine_only && !object.truth.fine) continue;
      translation += object.pose.translation_m;
      ++translations;
      if (object.continuous_symmetry) continue;
      rotation += object.pose.rotation_rad;
      ++rotations;
    }
    MeanPoseError mean;
    if (translations > 0) mean.translation_m = translation / translations;
    if (rotations > 0) mean.rotation_rad = rotation / rotations;
    return mean;
  }

  /// The walls of a scan are nothing that a map of objects could contain: from the true objects
  /// only.
  Status MeasureCompleteness() {
    PosedScene objects, map;
    for (std::size_t i = 0; i < truth_.size(); ++i) {
      objects.Add(truth_models_[i]->mesh, truth_[i].world_from_object, truth_[i].scale,
                  static_cast<int>(i));
    }
    for (std::size_t i = 0; i < estimates_.size(); ++i) {
      map.Add(estimate_models_[i]->mesh, AlignedPose(i), estimates_[i].scale, static_cast<int>(i));
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

  const TriangleMesh* scan_;
  const EvaluationOptions& options_;
  const UprightFrame upright_;
  /// Ignored instances too: they are really there.
  std::vector<std::tuple<Eigen::Isometry3d, double, const CadModel*>> surface_truth_;
  std::vector<GroundTruthInstance> truth_;
  std::vector<const CadModel*> truth_models_;
  std::vector<EstimatedObject> estimates_;
  std::vector<const CadModel*> estimate_models_;
  std::vector<ErrorStatistics> surface_of_estimate_;
  MapEvaluation evaluation_;
};

}  // namespace

Result<MapEvaluation> EvaluateMap(std::span<const EstimatedObject> estimates,
                                  const GroundTruth& truth, const ModelDatabase& database,
                                  const TriangleMesh* scan, const EvaluationOptions& options) {
  PLB_CHECK(options.samples > 0) << options.samples;
  Evaluator evaluator(truth.gravity_in_world, scan, options);
  if (const Status collected = evaluator.Collect(estimates, truth, database); !collected.ok())
    return collected.error();
  return evaluator.Run();
}

}  // namespace plumbline
