// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// Reads the bytes of a PCD file (Point Cloud Library, version 0.7): ascii, binary or
/// binary_compressed; position, and normals and colours if it has them; other fields are skipped,
/// points that are not finite (holes of an organised cloud) left out. Its VIEWPOINT is not applied.
/// @param file          Only for messages.
/// @param num_left_out  If given, how many.
/// Errors: kCorrupt (truncated, no position, no points), kUnsupported.
/// Source: https://pointclouds.org/documentation/tutorials/pcd_file_format.html
Result<TriangleMesh> ParsePcd(std::string_view bytes, const std::filesystem::path& file,
                              std::size_t* num_left_out = nullptr);

}  // namespace plumbline
