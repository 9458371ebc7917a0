// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "engine/geometry/mesh.h"

namespace plumbline {

/// A coarser mesh for looking at: vertices that share a cell of a cubic grid become one at their
/// mean, with their mean colour; triangles that collapse or repeat are dropped (Rossignac and
/// Borrel, "Multi-resolution 3D approximations for rendering complex scenes", 1993). Linear time.
/// Normals, texture coordinates and the texture are not kept. Point clouds stay point clouds.
///
/// @param cell_m  Edge of a cell, > 0.
TriangleMesh ClusterVertices(const TriangleMesh& mesh, double cell_m);

/// The same with cells as large as it takes to keep about `vertices` of them; the mesh itself if it
/// is that small.
TriangleMesh ClusterToAbout(const TriangleMesh& mesh, std::size_t vertices);

}  // namespace plumbline
