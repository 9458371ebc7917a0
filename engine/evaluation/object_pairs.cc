// SPDX-License-Identifier: Apache-2.0
#include "engine/evaluation/object_pairs.h"

#include <algorithm>

#include "engine/evaluation/model_point_errors.h"
#include "engine/geometry/diameter.h"

namespace plumbline {
namespace {

Result<const CadModel*> FindModel(const ModelDatabase& database, const std::string& name,
                                  const std::string& who) {
  const std::optional<ModelId> id = database.Find(name);
  if (!id) {
    return Error{ErrorCode::kNotFound, who + " is of the model '" + name + "', which " +
                                           (database.folder() / "models.json").string() +
                                           " does not have; give the database of that run"};
  }
  return &database.model(*id);
}

PointErrors PointErrorsOf(const MatchedObject& object, const Eigen::Isometry3d& pose,
                          const CadModel& model) {
  const Eigen::Affine3d estimate = pose * Eigen::Scaling(object.estimate.scale);
  const Eigen::Affine3d truth = object.truth.world_from_object * Eigen::Scaling(object.truth.scale);
  const ModelPoints points = PointsOf(model.mesh);
  return {AddError(estimate, truth, points), AddSError(estimate, truth, points),
          object.truth.scale * Diameter(model.mesh), model.symmetry.order != 1};
}

}  // namespace

Result<CountedObjects> CollectObjects(std::span<const EstimatedObject> estimates,
                                      const GroundTruth& truth, const ModelDatabase& database,
                                      const std::vector<std::string>& ignored_categories) {
  const auto is_ignored = [&](const std::string& category) {
    return std::find(ignored_categories.begin(), ignored_categories.end(), category) !=
           ignored_categories.end();
  };
  CountedObjects objects(truth.gravity_in_world);
  for (const GroundTruthInstance& instance : truth.instances) {
    const Result<const CadModel*> model =
        FindModel(database, instance.model, "ground truth instance " + instance.id);
    const bool ignored = is_ignored(instance.category);
    if (!model && !ignored) return model.error();
    if (model) objects.posed_truth.push_back({instance.world_from_object, instance.scale, *model});
    if (ignored) continue;
    objects.truths.push_back(instance);
    objects.truth_models.push_back(*model);
  }
  for (const EstimatedObject& estimate : estimates) {
    if (is_ignored(estimate.category)) continue;
    const Result<const CadModel*> model =
        FindModel(database, estimate.model, "object " + estimate.id);
    if (!model) return model.error();
    objects.estimates.push_back(estimate);
    objects.estimate_models.push_back(*model);
  }
  return objects;
}

std::vector<std::optional<int>> PairObjects(const CountedObjects& objects,
                                            const Eigen::Isometry3d& truth_from_estimate,
                                            double reach_m) {
  std::vector<PlacedThing> estimates, truths;
  for (const EstimatedObject& estimate : objects.estimates) {
    const Eigen::Vector3d origin = truth_from_estimate * estimate.world_from_object.translation();
    estimates.push_back({estimate.category, origin});
  }
  for (const GroundTruthInstance& instance : objects.truths)
    truths.push_back({instance.category, instance.world_from_object.translation()});
  return PairWithTruth(estimates, truths, reach_m);
}

MatchedObject CompareObject(const CountedObjects& objects,
                            const Eigen::Isometry3d& truth_from_estimate, std::size_t estimate,
                            std::size_t truth) {
  const CadModel& true_model = *objects.truth_models[truth];
  MatchedObject object;
  object.estimate = objects.estimates[estimate];
  object.truth = objects.truths[truth];
  const Eigen::Isometry3d pose = truth_from_estimate * object.estimate.world_from_object;
  const Eigen::Isometry3d& true_pose = object.truth.world_from_object;
  object.model_correct = object.estimate.model == object.truth.model;
  object.continuous_symmetry = true_model.symmetry.order == 0;
  object.pose = ComparePoses(pose, true_pose, true_model.symmetry, objects.upright);
  const Eigen::Vector3d center = objects.estimate_models[estimate]->center();
  object.centre_m = (pose * (object.estimate.scale * center) -
                     true_pose * (object.truth.scale * true_model.center()))
                        .norm();
  if (object.model_correct && !true_model.mesh.vertices.empty())
    object.add = PointErrorsOf(object, pose, true_model);
  return object;
}

MeanPoseError MeanOf(const std::vector<MatchedObject>& matched, bool fine_only) {
  double translation = 0, rotation = 0;
  int translations = 0, rotations = 0;
  for (const MatchedObject& object : matched) {
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

}  // namespace plumbline
