// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include "engine/evaluation/map_evaluation.h"

namespace plumbline {

/// Distances of one set of points to one surface.
struct SurfaceDistance {
  ErrorStatistics to_triangle;
  ErrorStatistics to_plane;  ///< To the plane of the closest triangle: never more.
};

/// How far a map's surface is from the truth, by each of the references that people use, side by
/// side. Rows that need a scan have nothing without one.
struct SurfaceReferences {
  /// To the scan alone, of what was scanned (ScannedSurface). Objects that are spurious count in
  /// full.
  struct Scanned {
    SurfaceDistance distance;
    double share = 0;  ///< Of the surface of the matched objects.
  };
  std::optional<Scanned> scanned;
  /// To the posed true models alone: they are the estimate's own meshes.
  SurfaceDistance posed;
  /// As the paper's text has it: after a rigid ICP onto the scan, along the normal, to the scan.
  struct Paper {
    SurfaceDistance distance;
    Eigen::Isometry3d truth_from_estimate = Eigen::Isometry3d::Identity();
    int matched = 0;
    MeanPoseError mean, mean_all;  ///< After the same alignment.
  };
  std::optional<Paper> paper;
  /// As the evaluation code published with VISMA means it: after a rigid ICP onto the scan within
  /// 7.5 cm, to the closest triangle of the posed true models.
  std::optional<SurfaceDistance> visma;
};

/// @param evaluation  Of the same input and options: its alignment is where all rows begin.
/// Errors: kDegenerate where the truth or the scan has no triangle; kNotFound as EvaluateMap.
Result<SurfaceReferences> CompareSurfaces(std::span<const EstimatedObject> estimates,
                                          const GroundTruth& truth, const ModelDatabase& database,
                                          const TriangleMesh* scan, const MapEvaluation& evaluation,
                                          const EvaluationOptions& options);

/// `surfaces` of `plumbline evaluate --json`.
nlohmann::json SurfacesToJson(const SurfaceReferences& references);

}  // namespace plumbline
