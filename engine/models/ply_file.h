// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// Reads the bytes of a PLY file: ascii or binary of either order, vertices with any of position,
/// normal, colour and texture coordinate (other properties and elements are skipped), faces as
/// lists of any integer type; polygons are cut into fans. Points of a cloud that are not finite are
/// left out.
/// @param file          Only for messages.
/// @param num_left_out  If given, how many.
/// @param labels        If given, the whole numbers of the vertices' property `label`; empty where
///                      there is none.
/// Errors: kCorrupt (truncated, no position, non-finite vertices of a mesh, indices out of range),
/// kUnsupported (triangle strips).
Result<TriangleMesh> ParsePly(std::string_view bytes, const std::filesystem::path& file,
                              std::size_t* num_left_out = nullptr,
                              std::vector<int>* labels = nullptr);

}  // namespace plumbline
