// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace plumbline {

/// A small scan to annotate, on disk: a floor with an armchair and a table, as points.
struct AnnotationScene {
  std::filesystem::path scan;    ///< scan.ply
  std::filesystem::path models;  ///< The database of MakeFurnitureDatabase.
  Eigen::Vector3d up_in_scan{0, 0, 1};
  Eigen::Isometry3d scan_from_armchair = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d scan_from_table = Eigen::Isometry3d::Identity();
};

/// @param scan_from_level  The floor is at z = 0 of `level`; the armchair stands at (0.4, 0.3) with
///                         azimuth 50 degrees, the table at (-0.9, -0.2) with azimuth 10 degrees.
AnnotationScene MakeAnnotationScene(
    const std::filesystem::path& folder,
    const Eigen::Isometry3d& scan_from_level = Eigen::Isometry3d::Identity());

}  // namespace plumbline
