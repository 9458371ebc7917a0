// SPDX-License-Identifier: Apache-2.0
#include "engine/recording/map_mesh.h"

#include <optional>

#include "engine/geometry/distinct_color.h"

namespace plumbline {

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
      mesh.colors.assign(mesh.vertices.size(), DistinctColor(static_cast<int>(i)));
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
