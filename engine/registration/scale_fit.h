// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>

#include "engine/base/progress.h"
#include "engine/base/result.h"
#include "engine/registration/constrained_fit.h"
#include "engine/registration/model_surface.h"
#include "engine/registration/scan_target.h"

namespace plumbline {

/// What is believed of an object's size before its scan is looked at: shapes of a database are
/// chosen because they nearly fit.
struct ScalePrior {
  double mean = 1, std = 0.03;  ///< Times as large as the model; std > 0.
};

/// How large a model is in a scan, and where.
struct ScaleFit {
  double scale = 1, scale_std = 0;
  Eigen::Isometry3d scan_from_model = Eigen::Isometry3d::Identity();  ///< Of the scaled model.
  int points = 0;  ///< Of the scan, that it was found by.
  bool converged = false;
};

/// Finds the scale of a model together with its pose: Gauss-Newton on the distances of scan points
/// along the normals of its closest triangles, with Tukey's weights, from a reach of 6 cm down to
/// 4.7 robust standard deviations. The model grows from its origin, the middle of its base, so that
/// what stands stays where it stands. The deviation counts points within patches of 15 cm as one
/// measurement each. See docs/algorithms/registration.md.
///
/// @param model       Unscaled.
/// @param start_scale Where to start from; off by no more than a few centimetres.
/// Errors: kDegenerate (no scan around the model), kCancelled.
Result<ScaleFit> FitScale(const ScanTarget& scan, const ModelSurface& model, double start_scale,
                          const Eigen::Isometry3d& scan_from_model,
                          const Eigen::Vector3d& up_in_scan, FreeMotion motion,
                          const ScalePrior& prior = {}, const WorkContext& context = {});

}  // namespace plumbline
