// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "engine/base/progress.h"
#include "engine/registration/icp.h"

namespace plumbline {

/// What a model stands on.
enum class Standing {
  kAnywhere,  ///< It may hang or stand on something that was not found: the scan decides.
  /// On the level surface below it: what floats must fit far better. What then stands within 3 cm
  /// of a known floor is put onto that exactly and fitted along it, where all translation is free.
  kOnSupport
};

struct AlignOptions {
  FreeMotion motion = FreeMotion::kAzimuthAndTranslation;
  Standing standing = Standing::kAnywhere;
  /// (a, b, c) = up, ax + by + cz + d = 0: the support where the scan shows none below the model
  /// and this lies within `search_m` of its foot.
  std::optional<Eigen::Vector4d> floor_in_scan;
  int starts = 24;         ///< Azimuths tried, evenly spread from the given one; >= 1.
  double search_m = 0.35;  ///< How far the model's origin may be from the start, > 0.
  double within_m = 0.02;  ///< Distance that counts as explained, > 0.
};

/// One minimum of the alignment.
struct AlignCandidate {
  Eigen::Isometry3d scan_from_model = Eigen::Isometry3d::Identity();
  double fitness = 0, rmse_m = 0;  ///< As of AlignmentFit.
  double score = 0;                ///< Likewise, less where the model does not stand; ranks them.
  bool stands = false;             ///< On the support that was found, within 3 cm.
  double sigma_m = 0;
  PoseCovariance covariance = PoseCovariance::Zero();
  int iterations = 0;
  bool converged = false;
  /// The best candidate turned by a symmetry of the model: the surface cannot tell them apart.
  bool same_by_symmetry = false;
};

struct ModelAlignment {
  std::vector<AlignCandidate> candidates;  ///< Distinct minima, best first; never empty.
  /// Rotational symmetry of the model's shape about its axis: 1 none, n-fold, 0 any turn (then the
  /// candidates' azimuths mean nothing).
  int symmetry_order = 1;
  int iterations = 0;  ///< Of all starts.
};

/// Puts a model onto a scan by iterated closest points under the constraint of gravity
/// (docs/algorithms/registration.md). Starts run in parallel; the result does not depend on the
/// number of threads.
///
/// @param scan_from_model  Roughly where the model is. Its tilt is kept exactly, unless the motion
///                         is kRigid.
/// @param up_in_scan       Unit vector against gravity.
/// Errors: kInvalidInput (options), kDegenerate (no scan near the start, or nothing that it fits
/// within `search_m`), kCancelled.
Result<ModelAlignment> AlignModel(const ScanTarget& scan, const ModelSurface& model,
                                  const Eigen::Isometry3d& scan_from_model,
                                  const Eigen::Vector3d& up_in_scan, const AlignOptions& options,
                                  const WorkContext& context = {});

}  // namespace plumbline
