// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include <Eigen/Core>

#include "engine/annotation/crop.h"
#include "engine/base/result.h"
#include "engine/registration/scan_target.h"

namespace plumbline {

/// What is known of where things stand in a scan.
struct BoxSurroundings {
  Eigen::Vector3d up_in_scan{0, 0, 1};
  std::optional<Eigen::Vector4d> floor_in_scan;  ///< (a, b, c) = up, ax + by + cz + d = 0.
  double view_azimuth_rad = 0;  ///< Of the eye, as of UprightFrame: the box's front faces it.
};

/// The upright box around the thing that a point of the scan belongs to: what hangs together with
/// it without floor, walls and, where a level surface lies all around below the point (a table
/// under a cup), without that; turned so that its ground plan is least, a finger wide all around;
/// down to the floor if it stands there. Errors: kDegenerate where there is nothing at the point,
/// or where what hangs together is wider than a piece of furniture.
Result<CropBox> BoxAround(const ScanTarget& scan, const Eigen::Vector3d& point_in_scan,
                          const BoxSurroundings& surroundings);

}  // namespace plumbline
