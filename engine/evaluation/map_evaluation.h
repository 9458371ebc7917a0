// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <nlohmann/json_fwd.hpp>

#include "engine/base/options.h"
#include "engine/base/result.h"
#include "engine/dataset/ground_truth.h"
#include "engine/evaluation/pose_error.h"
#include "engine/evaluation/surface_error.h"
#include "engine/evaluation/truth_pairing.h"
#include "engine/geometry/mesh.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// What a map says is there: an object that is not withdrawn.
struct EstimatedObject {
  std::string id;
  std::string model;  ///< Name in the model database.
  std::string category;
  Eigen::Isometry3d world_from_object = Eigen::Isometry3d::Identity();
  double scale = 1;                 ///< Times as large as its model.
  std::optional<double> scale_std;  ///< Nothing: the scale is not estimated.
  double probability = 1;           ///< That it is there.
  bool confirmed = true;
};

enum class Alignment { kNone, kTrajectory, kObjects, kIcp, kIcp4 };
template <>
struct EnumNames<Alignment> {
  static constexpr std::string_view names[] = {"none", "trajectory", "objects", "icp", "icp4"};
};

enum class TruthSurface { kBoth, kScan, kModels };
template <>
struct EnumNames<TruthSurface> {
  static constexpr std::string_view names[] = {"both", "scan", "models"};
};

struct EvaluationOptions {
  /// What brings the map into the frame of the truth: nothing, the trajectories (which is
  /// `truth_from_estimate`), a turn about up and a translation from the matched origins, ICP of the
  /// surfaces (rigid, as in the paper), or ICP that keeps gravity.
  Alignment align = Alignment::kNone;
  /// Where every alignment but `none` begins.
  Eigen::Isometry3d truth_from_estimate = Eigen::Isometry3d::Identity();
  /// The surface that counts as true: the scan and the posed models together (just the models where
  /// there is no scan).
  TruthSurface truth = TruthSurface::kBoth;
  std::vector<std::string> ignored_categories;  ///< Neither estimates nor truth of these count.
  double match_distance_m = kPairReach_m;       ///< Largest distance of the origins of a pair.
  int samples = 500'000;                        ///< Points on each surface.
  std::uint64_t seed = 0;                       ///< Of the sample points.
};

/// How far apart the model's vertices are in both poses (model_point_errors.h).
struct PointErrors {
  double add_m = 0, add_s_m = 0;
  double diameter_m = 0;   ///< Of the true model at its scale.
  bool symmetric = false;  ///< ADD-S is the one that counts.
};

/// An estimate and the instance that it was matched to.
struct MatchedObject {
  EstimatedObject estimate;
  GroundTruthInstance truth;
  bool model_correct = false;
  bool continuous_symmetry = false;  ///< Its rotation is not part of the means.
  PoseError pose;
  double centre_m = 0;             ///< Between the centres of the bounding boxes, at their scales.
  std::optional<PointErrors> add;  ///< Nothing with the wrong model: its vertices are others.
  ErrorStatistics surface;
};

struct SpuriousObject {
  EstimatedObject estimate;
  ErrorStatistics surface;
  /// Id of a moving thing of its category that came over its place; empty: none did.
  std::string moving;
};

/// Nothing where nothing was matched.
struct MeanPoseError {
  std::optional<double> translation_m, rotation_rad;
};

struct MapEvaluation {
  Eigen::Isometry3d truth_from_estimate = Eigen::Isometry3d::Identity();
  ErrorStatistics surface;                  ///< From the map to the true surface.
  ErrorStatistics surface_normal;           ///< The same to the plane of the closest triangle.
  ErrorStatistics completeness;             ///< From the true objects to the map.
  std::vector<MatchedObject> matched;       ///< In the order of the estimates.
  std::vector<SpuriousObject> spurious;     ///< Estimates without an instance.
  std::vector<GroundTruthInstance> missed;  ///< Instances without an estimate.
  MeanPoseError mean;                       ///< Over fine instances.
  MeanPoseError mean_all;                   ///< Over all.
};

/// Judges a map by the rules of docs/algorithms/evaluation.md. Same input, same result, bit for
/// bit.
/// @param scan  The scanned scene, in the frame of the truth; may be null.
/// Errors: kNotFound (a model that the database lacks), kInvalidInput (a scan is asked for and
/// there is none), kDegenerate (the true surface has no triangle).
Result<MapEvaluation> EvaluateMap(std::span<const EstimatedObject> estimates,
                                  const GroundTruth& truth, const ModelDatabase& database,
                                  const TriangleMesh* scan, const EvaluationOptions& options);

/// The result of `plumbline evaluate --json`. Lengths in metres, angles in degrees.
nlohmann::json EvaluationToJson(const MapEvaluation& evaluation, const EvaluationOptions& options);

}  // namespace plumbline
