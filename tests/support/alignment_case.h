// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "engine/models/model_database.h"

namespace plumbline {

struct AlignmentCaseOptions {
  int cameras = 2;         ///< That see the object from one side: 60 degrees between them.
  double noise_m = 0.004;  ///< Along the rays and along the scan's axes.
  bool clutter = true;     ///< Other furniture around, a box touching, a wall.
  /// Instead: a chair drawn up to a table over which the cameras look. They see the upper part of
  /// its back.
  bool under_table = false;
  double offset_m = 0.3;                        ///< Largest offset of the start.
  double azimuth_rad = 3.14159265358979323846;  ///< Largest turn of the start.
  bool tilted_scan = true;                      ///< Gravity in any direction.
};

/// A model that stands on a floor, scanned from one side, and a rough placement.
struct AlignmentCase {
  TriangleMesh scan;                                                  ///< Points.
  Eigen::Isometry3d scan_from_model = Eigen::Isometry3d::Identity();  ///< The truth.
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();            ///< Upright.
  Eigen::Vector3d up_in_scan{0, 0, 1};
  std::vector<Eigen::Vector3d> camera_centers;  ///< In the scan.
};

/// The same for the same seed. `model` is one of `models`; the rest is clutter.
AlignmentCase MakeAlignmentCase(const ModelDatabase& models, ModelId model, std::uint64_t seed,
                                const AlignmentCaseOptions& options = {});

}  // namespace plumbline
