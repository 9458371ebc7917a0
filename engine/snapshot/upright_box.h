// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace plumbline {

/// A box that stands upright, as the project knows up.
struct UprightBox {
  Eigen::Vector3d center_in_scan{0, 0, 0};
  Eigen::Vector3d size_m{1, 1, 1};  ///< Along its own axes.
  double azimuth_rad = 0;           ///< Of its x axis, as of UprightFrame.
};

}  // namespace plumbline
