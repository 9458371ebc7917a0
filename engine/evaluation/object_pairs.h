// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "engine/evaluation/map_evaluation.h"
#include "engine/geometry/gravity.h"

namespace plumbline {

/// A model in place: at `scene_from_object`, `scale` times as large as it is.
struct PosedModel {
  Eigen::Isometry3d scene_from_object = Eigen::Isometry3d::Identity();
  double scale = 1;
  const CadModel* model = nullptr;
};

/// Everything that counts in an evaluation, with its models found. The database must outlive it.
struct CountedObjects {
  UprightFrame upright;
  std::vector<EstimatedObject> estimates;
  std::vector<const CadModel*> estimate_models;
  std::vector<GroundTruthInstance> truths;
  std::vector<const CadModel*> truth_models;
  /// Ignored instances too: they are really there.
  std::vector<PosedModel> posed_truth;

  explicit CountedObjects(const Eigen::Vector3d& gravity) : upright(gravity) {}
};

/// Errors: kNotFound for a model that the database lacks, unless its category is ignored.
Result<CountedObjects> CollectObjects(std::span<const EstimatedObject> estimates,
                                      const GroundTruth& truth, const ModelDatabase& database,
                                      const std::vector<std::string>& ignored_categories);

/// The instances of the estimates, one to one within `reach_m`, once they are moved.
std::vector<std::optional<int>> PairObjects(const CountedObjects& objects,
                                            const Eigen::Isometry3d& truth_from_estimate,
                                            double reach_m);

/// The pose errors of one pair; `surface` is not filled.
MatchedObject CompareObject(const CountedObjects& objects,
                            const Eigen::Isometry3d& truth_from_estimate, std::size_t estimate,
                            std::size_t truth);

/// @param fine_only  Over instances of quality "fine" alone.
MeanPoseError MeanOf(const std::vector<MatchedObject>& matched, bool fine_only);

}  // namespace plumbline
