// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

struct SurfaceSamples {
  std::vector<Eigen::Vector3d> points;  ///< In the mesh's frame [m].
  std::vector<int> triangles;           ///< The triangle that point i lies on.
};

/// Draws `count` points uniformly by area: each face in proportion to its area, each point inside
/// its face. Sample i depends on the mesh, the seed and i only. Errors: kDegenerate if the mesh has
/// no face of positive area.
Result<SurfaceSamples> SampleSurface(const TriangleMesh& mesh, int count, std::uint64_t seed);

/// Total area of the faces [m^2].
double SurfaceArea(const TriangleMesh& mesh);

}  // namespace plumbline
