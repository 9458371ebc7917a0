// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <vector>

#include "engine/registration/constrained_fit.h"
#include "engine/registration/model_surface.h"
#include "engine/registration/scan_target.h"

namespace plumbline {

/// The part of a scan around the place where a model is to go, without the plane that it stands on.
struct AlignmentCrop {
  OrientedPoints coarse;  ///< A few hundred points, to find the way.
  OrientedPoints fine;    ///< A few thousand, to be exact.
  PointTree tree{{}};     ///< Of `fine`.
  bool normals_face_out = true;
  /// The height along up of the surface that the model may stand on, which is not in the crop.
  std::optional<double> support_m;
  double foot_m = 0;  ///< The model's lowest point along up, from its origin.

  /// How far a pose floats above the support (sunk: < 0).
  double Gap(const Eigen::Isometry3d& scan_from_model, const Eigen::Vector3d& up_in_scan) const {
    return scan_from_model.translation().dot(up_in_scan) + foot_m - support_m.value_or(0);
  }
};

inline constexpr double kStandsWithin_m = 0.03;

/// Takes what a model within `search_m` of `scan_from_model`, turned at will about up, could touch.
AlignmentCrop CropScan(const ScanTarget& scan, const ModelSurface& model,
                       const Eigen::Isometry3d& scan_from_model, const Eigen::Vector3d& up_in_scan,
                       double search_m);

inline constexpr double kLeastCoarseReach_m = 0.02;

/// Brings a model from as far as `reach_m` into the pull of the right minimum: point-to-point, then
/// point-to-plane, with a reach that shrinks down to `least_reach_m`. Returns the number of
/// iterations.
int AlignCoarsely(const AlignmentCrop& crop, const ModelSurface& model, double reach_m,
                  ConstrainedPose& pose, double least_reach_m = kLeastCoarseReach_m);

enum class IcpResidual { kPointToPoint, kPointToPlane };

struct FineAlignment {
  int iterations = 0;
  bool converged = false;
  double sigma_m = 0;  ///< Robust standard deviation of the distances used.
  PoseCovariance covariance = PoseCovariance::Zero();
};

/// Finishes the alignment: every scan point near the model to the closest point of its triangles,
/// so that surface that was not scanned takes no part. Tukey's weights; the scale is the data's
/// own. Where the model stands on the support, this counts as a measurement of its height, good to
/// 1 cm: it decides where the scan shows none.
FineAlignment AlignFinely(const AlignmentCrop& crop, const ModelSurface& model,
                          IcpResidual residual, int max_iterations, ConstrainedPose& pose);

/// How well a pose explains the scan.
struct AlignmentFit {
  double fitness = 0;  ///< Share of the model's surface with scan within `within_m`.
  double rmse_m = 0;   ///< Of the distances to the model of the scan points within `within_m`.
  double score = 0;    ///< For ranking: shares of model and scan explained, the near ones more.
};
AlignmentFit Measure(const AlignmentCrop& crop, const ModelSurface& model,
                     const Eigen::Isometry3d& scan_from_model, double within_m);

}  // namespace plumbline
