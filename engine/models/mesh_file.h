// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"
#include "engine/models/textured_mesh.h"

namespace plumbline {

/// Whether the name ends as those of files that may be meshes do, in any case.
bool IsMeshName(const std::filesystem::path& file);

/// Reads PLY (meshes and point clouds; ascii and both binary orders) and PCD (point clouds) by our
/// own readers, and whatever else assimp reads. Errors: kNotFound, kCorrupt (truncated, non-finite
/// vertices, indices out of range), kUnsupported, naming the file.
Result<TexturedMesh> ReadTexturedMesh(const std::filesystem::path& file);

/// The same for those who need no texture: it becomes colours of the vertices, with at most
/// `added_faces` more where it changes (PaintByTexture), and the file's unit, where one is stated,
/// metres. Axes as in the file.
Result<TriangleMesh> ReadMesh(const std::filesystem::path& file, int added_faces = 0);

/// Binary little-endian PLY with whatever attributes the mesh has. Errors: kIo.
Status WritePly(const std::filesystem::path& file, const TriangleMesh& mesh);

}  // namespace plumbline
