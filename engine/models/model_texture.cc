// SPDX-License-Identifier: Apache-2.0
#include "engine/models/model_texture.h"

namespace plumbline {

std::filesystem::path TextureOf(const ModelDatabase& models, const CadModel& model) {
  if (model.mesh.texture_file.empty() || model.mesh.texture_coordinates.empty()) return {};
  const std::filesystem::path file =
      models.folder() / std::filesystem::path(model.file).parent_path() / model.mesh.texture_file;
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored) ? file : std::filesystem::path();
}

}  // namespace plumbline
