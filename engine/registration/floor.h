// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "engine/registration/scan_target.h"

namespace plumbline {

/// The floor of a scan, and with it gravity.
struct FloorPlane {
  Eigen::Vector3d up_in_scan{0, 0, 1};  ///< Unit normal, towards the scene.
  double offset_m = 0;                  ///< up . x + offset = 0 on the floor.
  std::vector<int> inliers;             ///< Indices of scan points, rising.
  double rmse_m = 0;                    ///< Of the inliers' distances to the plane.
  double normal_std_rad = 0;            ///< Of the direction, if the distances are independent.
  /// Nothing was known but the scan: a wall may have been taken for the floor.
  bool guessed = false;
  double rival = 0;  ///< Evidence for the next best direction, as a share of this one's.

  /// z up, floor at z = 0, heading as of UprightFrame; no shift along the floor.
  Eigen::Isometry3d WorldFromScan() const;
};

struct FloorOptions {
  double thickness_m = 0.03;    ///< Points within this of the plane belong to it, > 0.
  double seed_radius_m = 0.15;  ///< Size of the first patch around a seed, > 0.
};

/// What else is known of the scan: all of it may be missing.
struct FloorHints {
  std::vector<Eigen::Vector3d> camera_centers;  ///< In the scan; above the floor.
  std::optional<Eigen::Vector3d> up_in_scan;    ///< Roughly, within 45 degrees.
};

/// Grows the plane from a point on the floor: a robust fit to the patch around the seed, then again
/// to everything connected that lies on it, until it stays. Errors: kDegenerate where there is no
/// plane around the seed.
Result<FloorPlane> FitFloorFrom(const ScanTarget& scan, const Eigen::Vector3d& seed_in_scan,
                                const FloorHints& hints = {}, const FloorOptions& options = {});

/// The widest plane that has the scene on one side (and, with a hint, lies across it). Without
/// hints it is told from bare walls by how the rest of the surfaces stands to it; what is
/// `guessed` so should be looked at. Errors: kDegenerate without any plane.
Result<FloorPlane> FindFloor(const ScanTarget& scan, const FloorHints& hints = {},
                             const FloorOptions& options = {});

/// The mean of the directions that the cameras' images have as up: a hint.
std::optional<Eigen::Vector3d> UpOfCameras(const std::vector<Eigen::Isometry3d>& scan_from_cam);

}  // namespace plumbline
