// SPDX-License-Identifier: Apache-2.0
#include "engine/models/scan_file.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "engine/models/pcd_file.h"
#include "engine/models/ply_file.h"

namespace plumbline {
namespace {

constexpr double kLargestRoom_m = 150;
constexpr std::size_t kLooksAt = 20'000;  ///< Points.

}  // namespace

Result<ScanFile> ReadScan(const std::filesystem::path& file) {
  ScanFile scan;
  const std::string ending = file.extension().string();
  const bool ply = ending == ".ply" || ending == ".PLY", pcd = ending == ".pcd" || ending == ".PCD";
  Result<TriangleMesh> mesh = [&]() -> Result<TriangleMesh> {
    if (!ply && !pcd) return ReadMesh(file);
    const auto bytes = ReadFile(file);
    if (!bytes.ok()) return bytes.error();
    return ply ? ParsePly(*bytes, file, &scan.num_left_out)
               : ParsePcd(*bytes, file, &scan.num_left_out);
  }();
  if (!mesh.ok()) return mesh.error();
  scan.mesh = std::move(*mesh);
  return scan;
}

std::optional<double> TooLargeForMetres(const TriangleMesh& scan) {
  const std::size_t stride = std::max<std::size_t>(1, scan.vertices.size() / kLooksAt);
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> along;
    for (std::size_t i = 0; i < scan.vertices.size(); i += stride)
      along.push_back(scan.vertices[i][axis]);
    if (along.empty()) return std::nullopt;
    // Stray points may be anywhere.
    const auto at = [&](double share) {
      const auto place = along.begin() +
                         static_cast<std::ptrdiff_t>(share * static_cast<double>(along.size() - 1));
      std::nth_element(along.begin(), place, along.end());
      return static_cast<double>(*place);
    };
    const double low = at(0.05), high = at(0.95);
    largest = std::max(largest, high - low);
  }
  return largest > kLargestRoom_m ? std::optional(largest) : std::nullopt;
}

}  // namespace plumbline
