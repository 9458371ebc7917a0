// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "engine/base/result.h"
#include "engine/geometry/mesh.h"

namespace plumbline {

/// A scan as its file has it, and what was left out of it.
struct ScanFile {
  TriangleMesh mesh;
  std::size_t num_left_out = 0;  ///< Points of a cloud that are not finite.
};

/// Errors: of ReadMesh.
Result<ScanFile> ReadScan(const std::filesystem::path& file);

/// How large a scan of a room would be, if its unit were the metre and that cannot be: nine tenths
/// of it span more than 150 m. Nothing: it can be.
std::optional<double> TooLargeForMetres(const TriangleMesh& scan);

}  // namespace plumbline
