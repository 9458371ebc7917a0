// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/registration/constrained_fit.h"
#include "engine/registration/scan_target.h"

// Where the world of a sequence is in a scan: a turn about gravity and a translation; gravity is
// known in both. docs/algorithms/sequence_alignment.md.

namespace plumbline {

/// Down in both frames, unit vectors.
struct GravityPair {
  Eigen::Vector3d in_world{0, 0, -1}, in_scan{0, 0, -1};
};

/// A line of sight: a pixel that was clicked.
struct WorldRay {
  Eigen::Vector3d origin_in_world{0, 0, 0}, direction_in_world{0, 0, 1};  ///< Unit direction.
  double pixel_rad = 1e-3;                                                ///< Angle of one pixel.
};

/// The same point in the scan and in the sequence.
struct PickedPair {
  Eigen::Vector3d in_scan{0, 0, 0};
  std::variant<WorldRay, Eigen::Vector3d> in_world;
};

/// Where the world was found to be.
struct SequenceAlignment {
  Eigen::Isometry3d scan_from_world = Eigen::Isometry3d::Identity();
  /// Of the world's place at the middle of what was compared: x, y, z in the scan [m].
  Eigen::Vector3d position_std_m{0, 0, 0};
  double azimuth_std_rad = 0;
  /// Of each pair: metres for points, pixels for rays; of each object: metres.
  std::vector<double> residuals;
  double rmse_m = 0;  ///< Of the points used.
  double share = 1;   ///< Of points or objects that were used.
  int iterations = 0;
};

/// From picked pairs, by least squares: the azimuth that lets the closed-form translation explain
/// them best. A point counts with 2 cm, a click with 2 pixels, or with what the residuals say if
/// that is more. Errors: kInvalidInput (gravity is no unit vector, fewer than two pairs),
/// kDegenerate (the pairs do not show turn and place: spread them).
Result<SequenceAlignment> AlignByPairs(const std::vector<PickedPair>& pairs,
                                       const GravityPair& gravity);

/// Sparse points of the sequence's map onto the scan by point-to-plane ICP, from a rough place or,
/// without one, from many azimuths about the middles of both. Far points are left out. Errors:
/// kInvalidInput (fewer than 30 points), kDegenerate (nothing meets), kCancelled.
Result<SequenceAlignment> AlignByPoints(const std::vector<Eigen::Vector3f>& points_in_world,
                                        const ScanTarget& scan, const GravityPair& gravity,
                                        const std::optional<Eigen::Isometry3d>& scan_from_world,
                                        const WorkContext& work = {});

/// An object that was mapped, or annotated.
struct PosedObject {
  std::string kind;  ///< Objects of one kind can be the same.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
};

/// From mapped objects to annotated ones: the place at which most of them meet an own partner of
/// their kind within half a metre. `residuals`: of each mapped object, negative where it meets
/// none. Errors: kInvalidInput (gravity), kDegenerate (no two meet, nor one whose turn tells the
/// rest).
Result<SequenceAlignment> AlignByObjects(const std::vector<PosedObject>& mapped_in_world,
                                         const std::vector<PosedObject>& annotated_in_scan,
                                         const GravityPair& gravity);

}  // namespace plumbline
