// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/registration/icp.h"

namespace plumbline {

/// Open3D's point-to-plane ICP (six degrees of freedom), model to scan, reach 0.3, 0.1 and 0.03 m,
/// from `starts` azimuths; the best by its fitness, then its RMSE, within 0.02 m. Built only where
/// libopen3d-dev is installed.
Eigen::Isometry3d AlignWithOpen3d(const AlignmentCrop& crop, const ModelSurface& surface,
                                  const Eigen::Isometry3d& start, const Eigen::Vector3d& up,
                                  int starts);

}  // namespace plumbline
