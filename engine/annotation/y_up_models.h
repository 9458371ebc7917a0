// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <Eigen/Geometry>

#include "engine/geometry/mesh.h"

namespace plumbline {

/// Ours (z up) from a model turned y up, as VISMA and ShapeNet have them: (x, y, z) -> (x, -z, y).
Eigen::Isometry3d ObjectFromYUp();

/// An OBJ of a z-up mesh, turned y up: metres, six columns a vertex (place and colour, grey without
/// any).
std::string YUpObj(const TriangleMesh& mesh);

}  // namespace plumbline
