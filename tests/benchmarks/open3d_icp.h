// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/registration/icp.h"

namespace plumbline {

enum class Open3dSteps {
  kRigid,
  /// Of each rigid step only the turn about up is kept, about the middle of the pairs, which moves
  /// as the step has it.
  kProjected
};

/// Open3D's point-to-plane ICP, model to scan, reach 0.3, 0.1 and 0.03 m, from `starts` azimuths;
/// the best by its fitness, then its RMSE, within 0.02 m. Built only where libopen3d-dev is
/// installed.
Eigen::Isometry3d AlignWithOpen3d(const AlignmentCrop& crop, const ModelSurface& surface,
                                  const Eigen::Isometry3d& start, const Eigen::Vector3d& up,
                                  int starts, Open3dSteps steps);

/// Open3D's global registration as its tutorial has it (voxels of 3 cm, FPFH features within 15 cm,
/// RANSAC over 100 000 triples, edges alike to 10 %, pairs within 4.5 cm), then its point-to-plane
/// ICP, reach 0.06 and 0.03 m. Takes no start and no direction of up.
Eigen::Isometry3d AlignByFeatures(const AlignmentCrop& crop, const ModelSurface& surface);

}  // namespace plumbline
