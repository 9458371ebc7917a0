// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "engine/dataset/ground_truth.h"
#include "engine/evaluation/truth_pairing.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// One object that both annotators placed. Differences are the first minus the second.
struct AgreedObject {
  GroundTruthInstance first, second;
  bool same_model = true;
  bool fine = true;     ///< Both say so.
  bool copied = false;  ///< Both poses are the same to the last digit: nobody placed it twice.
  Eigen::Vector3d difference_m{0, 0, 0};  ///< Along the level axes, z up.
  std::optional<double> azimuth_rad;      ///< Nothing for round models.
  double tilt_rad = 0;                    ///< Between the up axes.
  /// What this one difference says of one annotator: |d| / sqrt(2).
  double position_std_m = 0;
  std::optional<double> azimuth_std_rad;

  double horizontal_m() const { return difference_m.head<2>().norm(); }
};

/// One standard deviation of one annotator, pooled over objects. Of two annotators who are equally
/// good the difference d of a coordinate has the variance 2 sigma^2, so sigma^2 = mean(d^2) / 2.
struct PooledDeviation {
  int objects = 0;             ///< Placed twice, with the same model.
  int azimuths = 0;            ///< Of them, not round.
  double horizontal_m = 0;     ///< Of one horizontal coordinate: two of each object.
  double height_m = 0;         ///< Of the height.
  double position_std_m = 0;   ///< Of all three: root of the mean squared distance.
  double azimuth_std_rad = 0;  ///< 0 where `azimuths` is.
};

/// Fewer objects than these say nothing of an annotator.
inline constexpr int kLeastPooled = 3;

struct AnnotatorAgreement {
  std::vector<AgreedObject> objects;  ///< In the order of the first.
  std::vector<GroundTruthInstance> only_first, only_second;
  PooledDeviation fine, coarse, all;
};

/// How well two annotators agree on one scene. Objects of a category are paired one to one within
/// `reach_m` (PairWithTruth). Symmetries are those of the database, of models that both name alike;
/// without a database nothing is symmetric.
/// @param first, second  In one frame; gravity is that of the first.
AnnotatorAgreement CompareAnnotators(const GroundTruth& first, const GroundTruth& second,
                                     const ModelDatabase* models, double reach_m = kPairReach_m);

/// How well the poses of the first are known, by id: pooled over the objects of the same quality,
/// and where this object differs more, by that. Only of objects that both placed with the same
/// model, where there are kLeastPooled of their quality: a difference that is small by chance says
/// nothing.
void SetDeviations(const AnnotatorAgreement& agreement, GroundTruth& first);

}  // namespace plumbline
