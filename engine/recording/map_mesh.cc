// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/map_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

namespace plumbline {
namespace {

/// Tells object `index` from its neighbours in number: hues by the golden angle.
std::array<std::uint8_t, 3> ColorOf(int index) {
  const double hue = std::fmod(index * 137.50776405, 360.0) / 60.0;
  const auto channel = [&](double shift) {
    const double k = std::fmod(shift + hue, 6.0);
    const double value = 0.9 * (1 - 0.65 * std::clamp(std::min(k, 4 - k), 0.0, 1.0));
    return static_cast<std::uint8_t>(std::lround(255 * value));
  };
  return {channel(5), channel(3), channel(1)};
}

}  // namespace

Result<TriangleMesh> MapMesh(std::span<const EstimatedObject> objects,
                             const ModelDatabase& database, MapColors colors) {
  TriangleMesh scene;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::optional<ModelId> id = database.Find(objects[i].model);
    if (!id) {
      return Error{ErrorCode::kNotFound, "object " + objects[i].id + " is of the model '" +
                                             objects[i].model + "', which " +
                                             database.folder().string() + " does not have"};
    }
    TriangleMesh mesh = Transformed(Scaled(database.model(*id).mesh, objects[i].scale),
                                    objects[i].world_from_object);
    if (colors == MapColors::kByObject) {
      mesh.colors.assign(mesh.vertices.size(), ColorOf(static_cast<int>(i)));
    } else if (mesh.colors.empty()) {
      mesh.colors.assign(mesh.vertices.size(), {200, 200, 200});
    }
    mesh.texture_coordinates.clear();
    mesh.texture_file.clear();
    Append(mesh, scene);
  }
  return scene;
}

}  // namespace plumbline
