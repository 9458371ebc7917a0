// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "engine/evaluation/map_evaluation.h"
#include "engine/evaluation/standing_box.h"
#include "engine/sensor/camera.h"

namespace plumbline {

/// KITTI's levels of difficulty, by what boxes tell: how high one is in the image and how much of
/// it the border cuts off. How much something hides is not told by boxes and does not count here.
enum class KittiLevel { kEasy, kModerate, kHard };
inline constexpr std::array<std::string_view, 3> kKittiLevelNames = {"easy", "moderate", "hard"};

/// The easiest level that a box meets in one of the images; nothing where it meets none: too small,
/// or cut off too much, in all of them.
struct KittiViews {
  PinholeCamera camera;
  std::vector<Eigen::Isometry3d> cam_from_world;  ///< One for each image.
};
std::optional<KittiLevel> LevelIn(const KittiViews& views, const StandingBox& box,
                                  const UprightFrame& upright);

/// A box and where it heads.
struct KittiBox {
  StandingBox box;
  double azimuth_rad = 0;
  std::optional<KittiLevel> level;
};
struct KittiCandidate : KittiBox {
  double score = 0;
};

/// Of one way to overlap at one level.
struct KittiPrecision {
  /// Average precision and average orientation similarity, over 40 places of recall (1/40 .. 1) and
  /// over 11 (0, 0.1 .. 1). In [0, 1].
  double ap_40 = 0, ap_11 = 0, aos_40 = 0, aos_11 = 0;
  int truths = 0, found = 0, wrong = 0;  ///< That count at this level.
};

enum class KittiOverlap { kVolume, kBase };

/// Candidates, by falling score, each take the true box that is not taken and that they overlap
/// most, if by `least_iou`. True boxes harder than `level` neither count nor may be missed, and nor
/// do candidates that take one, or that take none and are harder themselves.
/// Formulas and sources: docs/algorithms/evaluation.md.
KittiPrecision KittiPrecisionOf(std::vector<KittiCandidate> candidates,
                                std::span<const KittiBox> truths, KittiOverlap overlap,
                                double least_iou, KittiLevel level);

/// How a matched object's box lies to the true one.
struct KittiPair {
  std::string estimate, truth;
  double iou = 0, base_iou = 0;
  double orientation = 0;  ///< Similarity (1 + cos) / 2, in [0, 1].
};

/// KITTI's measures of one category.
struct KittiMeasures {
  std::string category;
  static constexpr std::array<double, 2> kLeastIous = {0.7, 0.5};
  /// By least overlap, then by level.
  std::array<std::array<KittiPrecision, 3>, 2> volume, base;
  std::vector<KittiPair> pairs;  ///< Of the evaluation's matches.
  bool has_levels = false;       ///< Without views every box is easy.
};

/// @param candidates  All that the map holds, tentative objects too, in the frame of the map.
/// @param views       In the frame of the truth; none: no levels.
/// Errors: kNotFound as EvaluateMap.
Result<KittiMeasures> MeasureKitti(std::span<const EstimatedObject> candidates,
                                   const GroundTruth& truth, const ModelDatabase& database,
                                   const MapEvaluation& evaluation, const std::string& category,
                                   const std::optional<KittiViews>& views);

/// `kitti` of `plumbline evaluate --json`.
nlohmann::json KittiToJson(const KittiMeasures& measures);

}  // namespace plumbline
