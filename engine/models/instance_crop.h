// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Geometry>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// A scan whose vertices say which instance they belong to.
struct LabelledMesh {
  TriangleMesh mesh;
  std::vector<int> labels;  ///< One a vertex.
};

/// Reads a PLY whose vertices have a property `label`, as SceneNN's. Errors: kNotFound, kCorrupt,
/// kInvalidInput without that property, naming the file.
Result<LabelledMesh> ReadLabelledMesh(const std::filesystem::path& file);

/// The triangles all of whose corners have this label, in the frame of the scan.
TriangleMesh CropByLabel(const LabelledMesh& scan, int label);

/// A model cut out of a scan, as models.json wants one.
struct UprightCrop {
  TriangleMesh mesh;  ///< In `object`: z up, the origin in the middle of its footprint.
  Eigen::Isometry3d scan_from_object = Eigen::Isometry3d::Identity();
};
/// Brings a crop upright, at azimuth 0 (UprightFrame): its own front is not known.
/// @param gravity_in_scan  Down; any length > 0.
UprightCrop UprightModel(const TriangleMesh& crop, const Eigen::Vector3d& gravity_in_scan);

}  // namespace plumbline
