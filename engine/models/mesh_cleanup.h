// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "engine/geometry/mesh.h"

namespace plumbline {

struct CleanupReport {
  int merged_vertices = 0;
  int degenerate_faces = 0;  ///< Without area, or with a corner twice.
  int duplicate_faces = 0;   ///< The same three corners in any order: faces are drawn two-sided.
  int unreferenced_vertices = 0;
};

/// The same surface with vertices merged that lie at one place (within 1e-6 of the mesh's diagonal)
/// and agree in colour and texture coordinates, without degenerate and duplicate faces and
/// unreferenced vertices. Normals are dropped: they belong to the old vertices.
TriangleMesh CleanMesh(const TriangleMesh& mesh, CleanupReport& report);

/// The same with vertices merged by place alone and no attributes: the surface without texture
/// seams.
TriangleMesh WeldedGeometry(const TriangleMesh& mesh);

/// For every vertex the first one that lies where it lies (as for CleanMesh).
std::vector<int> FirstAtEachPlace(const TriangleMesh& mesh);

struct EdgeCounts {
  int open = 0;          ///< Edges of one face.
  int non_manifold = 0;  ///< Edges of three or more.
};

/// Counted on the welded geometry, so that texture seams are no open edges.
EdgeCounts CountEdges(const TriangleMesh& mesh);

}  // namespace plumbline
