// SPDX-License-Identifier: Apache-2.0
#include "engine/synthetic/room_files.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/models/mesh_file.h"
#include "engine/synthetic/film.h"

namespace plumbline {
namespace {

using Eigen::Vector3f;

/// Vertices of one part that lie in the same place are one vertex.
std::uint64_t PlaceKey(const Vector3f& position, std::uint16_t part) {
  std::uint64_t key = part;
  for (int axis = 0; axis < 3; ++axis) {
    key =
        key * 4000037 + static_cast<std::uint64_t>(std::llround(position[axis] / 1e-4f) + 1000000);
  }
  return key;
}

}  // namespace

TriangleMesh ScanOfRoom(const Room& room, const RayTracer& tracer, float spacing_m) {
  TriangleMesh scan;
  std::unordered_map<std::uint64_t, int> known;
  const TracedScene& scene = tracer.scene();
  for (std::uint32_t t = 0; t < scene.triangles().size(); ++t) {
    const TracedScene::Triangle& triangle = scene.triangles()[t];
    if (!room.parts[triangle.part].in_scan) continue;
    std::array<Vector3f, 3> corner;
    for (int k = 0; k < 3; ++k)
      corner[k] = scene.vertices()[static_cast<std::size_t>(triangle.corners[k])];
    const float longest = std::max({(corner[1] - corner[0]).norm(), (corner[2] - corner[1]).norm(),
                                    (corner[0] - corner[2]).norm()});
    const int steps = std::max(1, static_cast<int>(std::ceil(longest / spacing_m)));
    const auto vertex = [&](int i, int j) {
      const float u = static_cast<float>(i) / static_cast<float>(steps),
                  v = static_cast<float>(j) / static_cast<float>(steps);
      const Vector3f position =
          corner[0] + u * (corner[1] - corner[0]) + v * (corner[2] - corner[0]);
      const auto [entry, fresh] = known.try_emplace(PlaceKey(position, triangle.part),
                                                    static_cast<int>(scan.vertices.size()));
      if (fresh) {
        const Vector3f color = tracer.ScannedColor({t, 0, u, v}, spacing_m);
        std::array<std::uint8_t, 3> rgb;
        for (int c = 0; c < 3; ++c) {
          rgb[c] = static_cast<std::uint8_t>(
              std::lround(255 * EncodeSrgb(ToneCurve(color[c] * tracer.exposure()))));
        }
        scan.vertices.push_back(position);
        scan.colors.push_back(rgb);
      }
      return entry->second;
    };
    const auto add = [&](int a, int b, int c) {
      if (a != b && b != c && a != c) scan.triangles.emplace_back(a, b, c);
    };
    for (int j = 0; j < steps; ++j) {
      for (int i = 0; i + j < steps; ++i) {
        add(vertex(i, j), vertex(i + 1, j), vertex(i, j + 1));
        if (i + j + 1 < steps) add(vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1));
      }
    }
  }
  return scan;
}

Status WriteModels(const std::filesystem::path& folder,
                   const std::vector<FurnitureModel>& catalogue) {
  nlohmann::json models = nlohmann::json::array();
  for (const FurnitureModel& model : catalogue) {
    const TriangleMesh mesh = DatabaseMesh(model.body);
    const Status written = WritePly(folder / (model.name + ".ply"), mesh);
    if (!written.ok()) return written;
    models.push_back({{"name", model.name},
                      {"file", model.name + ".ply"},
                      {"category", model.category},
                      {"symmetry", {{"axis", {0, 0, 1}}, {"order", model.symmetry_order}}},
                      {"support", model.support == Support::kFloor ? "floor" : "any"},
                      {"faces", mesh.triangles.size()},
                      {"note", model.note}});
  }
  return WriteJson(folder / "models.json", {{"units", "m"}, {"models", models}});
}

}  // namespace plumbline
