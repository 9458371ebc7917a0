// SPDX-License-Identifier: Apache-2.0
#pragma once

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
};

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
/// own.
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
