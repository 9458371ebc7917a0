// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// Reads OBJ, GLB, GLTF, STL through assimp, and PLY (meshes and point clouds; ascii and both
/// binary orders) and PCD (point clouds) by our own readers. Units and axes as in the file. Errors:
/// kNotFound, kCorrupt (truncated, non-finite vertices, indices out of range), kUnsupported, naming
/// the file.
Result<TriangleMesh> ReadMesh(const std::filesystem::path& file);

/// Binary little-endian PLY with whatever attributes the mesh has. Errors: kIo.
Status WritePly(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace plumbline
