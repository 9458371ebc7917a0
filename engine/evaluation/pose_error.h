// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "engine/geometry/gravity.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// How far an object's estimated pose is from the true one.
struct PoseError {
  double translation_m = 0;  ///< Between the origins.
  double rotation_rad = 0;   ///< ||log(R^T R_truth)||, minimum over the symmetry group.
  std::optional<double>
      azimuth_rad;  ///< Estimate minus truth about up, (-pi, pi]; nothing for continuous symmetry.
  double tilt_rad =
      0;  ///< Between the objects' up axes (for continuous symmetry: the symmetry axes).
  double height_m = 0;  ///< Estimate minus truth along up.
};

/// For continuous symmetry (order 0) the rotation is the tilt: the rest cannot be seen.
PoseError ComparePoses(const Eigen::Isometry3d& world_from_estimate,
                       const Eigen::Isometry3d& world_from_truth, const Symmetry& symmetry,
                       const UprightFrame& upright);

}  // namespace plumbline
