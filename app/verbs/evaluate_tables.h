// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/analysis/planted_truth.h"
#include "engine/analysis/run_review.h"
#include "engine/analysis/shown_truths.h"
#include "engine/analysis/single_frames.h"
#include "engine/analysis/trajectory_alignment.h"
#include "engine/evaluation/box_detection.h"
#include "engine/evaluation/kitti_measures.h"
#include "engine/evaluation/placement_success.h"
#include "engine/evaluation/surface_references.h"
#include "engine/snapshot/truths_view.h"

namespace plumbline {

/// By the instances' names.
using PlantedTruths = std::map<std::string, PlantedTruth>;

/// All that `plumbline evaluate` says of one map.
struct JudgedMap {
  EvaluationOptions options;
  bool has_scan = false;
  MapEvaluation evaluation;
  SurfaceReferences surfaces;
  PlacementSuccess placement;
  BoxDetection detection;
  std::optional<KittiMeasures> kitti;
  std::optional<TrajectoryFit> by_trajectory;
  std::optional<TruthsView> truths;  ///< Why instances are missed; nothing: not known.
  PlantedTruths planted;
  std::optional<SingleFrames> single_frames;  ///< Nothing where the map is of no single frames.
};

void PrintJudgedMap(const JudgedMap& map);
nlohmann::json JudgedMapToJson(const JudgedMap& map);

/// How honest the beliefs of a run were.
/// @param truths  How many instances there are.
void PrintReliability(const RunHistory& history, int truths);

}  // namespace plumbline
