// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// Reads the bytes of a PLY file: ascii or binary of either order, vertices with any of position,
/// normal, colour and texture coordinate (other properties and elements are skipped), faces as
/// lists of any integer type; polygons are cut into fans. `file` is only for messages. Errors:
/// kCorrupt (truncated, no position, non-finite vertices, indices out of range), kUnsupported
/// (triangle strips).
Result<TriangleMesh> ParsePly(std::string_view bytes, const std::filesystem::path& file);

}  // namespace plumbline
