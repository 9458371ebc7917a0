// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/evaluation/map_evaluation.h"

namespace plumbline {

/// Average precision of 3-D boxes at one threshold of their overlap.
struct BoxPrecision {
  std::map<std::string, double> by_category;  ///< Of which there is something true.
  std::optional<double> mean;                 ///< Over these; nothing without truth.
};

struct BoxDetection {
  BoxPrecision at_25, at_50;  ///< Intersection over union of at least 0.25, 0.5.
  int candidates = 0;         ///< That were ranked.
};

/// Average precision of detection, as benchmarks of indoor scenes count it (ScanNet, SUN RGB-D):
/// boxes that stand upright and are turned about gravity, ranked by how likely they are there.
/// @param candidates  All that the map holds, tentative objects too, in the frame of the map.
/// Errors: kNotFound as EvaluateMap.
Result<BoxDetection> MeasureDetection(std::span<const EstimatedObject> candidates,
                                      const GroundTruth& truth, const ModelDatabase& database,
                                      const MapEvaluation& evaluation,
                                      const EvaluationOptions& options);

/// `detection` of `plumbline evaluate --json`.
nlohmann::json DetectionToJson(const BoxDetection& detection);

}  // namespace plumbline
