// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"
#include "engine/synthetic/ray_tracer.h"
#include "engine/synthetic/room.h"

namespace plumbline {

/// The room as a scanner would give it: coloured triangles in the room's frame, about `spacing_m`
/// apart, without ceiling.
TriangleMesh ScanOfRoom(const Room& room, const RayTracer& tracer, float spacing_m);

/// Writes the catalogue as a model database (PLY meshes and models.json). Errors: kIo.
Status WriteModels(const std::filesystem::path& folder,
                   const std::vector<FurnitureModel>& catalogue);

}  // namespace plumbline
