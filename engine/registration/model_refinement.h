// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "engine/base/progress.h"
#include "engine/registration/icp.h"

namespace plumbline {

/// How far an alignment has come that starts from exactly where a model is.
struct ModelRefinement {
  Eigen::Isometry3d scan_from_model = Eigen::Isometry3d::Identity();
  int iterations = 0;
  bool converged = false;
  AlignmentFit before, fit;                            ///< Within 2 cm.
  PoseCovariance covariance = PoseCovariance::Zero();  ///< At the end only.
};

/// Aligns a model that is at most 10 cm off, as AlignModel does from one start: first to where the
/// reach shrinks to, then exactly. The tilt is kept, unless the motion is kRigid.
///
/// @param up_in_scan  Unit vector against gravity.
/// @param step        Is told every iteration, the last one included.
/// Errors: kDegenerate (no scan around the model), kCancelled.
Result<ModelRefinement> RefineModel(const ScanTarget& scan, const ModelSurface& model,
                                    const Eigen::Isometry3d& scan_from_model,
                                    const Eigen::Vector3d& up_in_scan, FreeMotion motion,
                                    const std::function<void(const ModelRefinement&)>& step,
                                    const WorkContext& context = {});

/// Distance of each point of a posed model to the nearest point of the scan [m]; -1 where there is
/// none within `reach_m`.
std::vector<float> DistancesToScan(const ScanTarget& scan,
                                   std::span<const Eigen::Vector3f> points_in_model,
                                   const Eigen::Isometry3d& scan_from_model, double reach_m);

}  // namespace plumbline
