// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/evaluation/map_evaluation.h"
#include "engine/geometry/angles.h"

namespace plumbline {

/// Scan2CAD's limits for a model that stands right: A. Avetisyan et al., "Scan2CAD: Learning CAD
/// model alignment in RGB-D scans", CVPR 2019.
inline constexpr double kSuccess_m = 0.2, kSuccess_rad = 20 * kRadPerDeg, kSuccessScale = 0.2;
/// ADD and ADD-S pass below this share of the model's diameter: S. Hinterstoisser et al., ACCV
/// 2012.
inline constexpr double kAddShare = 0.1;

/// How many true instances have an estimate that stands right.
struct SuccessCount {
  int right = 0, truths = 0;
  double share() const { return truths > 0 ? static_cast<double>(right) / truths : 0.0; }
};

/// What the criteria of other benchmarks say of a map.
struct PlacementSuccess {
  std::map<std::string, SuccessCount> by_category;  ///< Scan2CAD's.
  SuccessCount all;                                 ///< Over instances.
  std::optional<double> category_mean;              ///< Of the shares; nothing without truth.
  /// ADD for models without a symmetry, ADD-S for the others; the model has to be the right one.
  SuccessCount add;
};

/// Judges the aligned objects of an evaluation, spurious ones included. Scan2CAD: one to one, as
/// many pairs of one category within the limits as there can be.
/// @param database  That of the evaluation.
PlacementSuccess MeasurePlacement(const MapEvaluation& evaluation, const GroundTruth& truth,
                                  const ModelDatabase& database);

/// `placement` of `plumbline evaluate --json`.
nlohmann::json PlacementToJson(const PlacementSuccess& placement);

}  // namespace plumbline
