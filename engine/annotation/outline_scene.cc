// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/outline_scene.h"

namespace plumbline {

Result<std::shared_ptr<const OutlineModel>> OutlineScene::Model(const std::string& name,
                                                                double scale) {
  if (const auto known = prepared_.find({name, scale}); known != prepared_.end())
    return known->second;
  const auto id = models_ ? models_->Find(name) : std::nullopt;
  if (!id) {
    return Error{ErrorCode::kNotFound, "there is no model '" + name + "' in the database"};
  }
  auto model = OutlineModel::Prepare(Scaled(models_->model(*id), scale).mesh);
  if (!model) return Error{model.error().code, "'" + name + "': " + model.error().message};
  prepared_.emplace(std::pair(name, scale), *model);
  return *model;
}

Occluders OutlineScene::OccludersOf(const AnnotationDocument& document, const std::string& id) {
  Occluders occluders{scan_, {}};
  for (const AnnotatedInstance& other : document.instances) {
    if (other.id == id) continue;
    if (const auto model = Model(other.model, other.scale)) {
      occluders.models.push_back({*model, other.scan_from_object});
    }
  }
  return occluders;
}

}  // namespace plumbline
