// SPDX-License-Identifier: Apache-2.0
#include "engine/annotation/crop_models.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "engine/base/files.h"
#include "engine/models/model_move.h"

namespace plumbline {

std::filesystem::path UndoneModels(const std::filesystem::path& models_folder) {
  return models_folder / ".undone";
}

namespace {

/// Leaves no empty folder of undone models, whatever cut short what filled or emptied it.
void RemoveIfEmpty(const std::filesystem::path& undone) {
  std::error_code ignored;
  if (!std::filesystem::is_directory(undone, ignored)) return;
  const std::filesystem::path file = undone / "models.json";
  const auto list = ReadJson(file);
  if (list && list->is_object() &&
      list->value("models", nlohmann::json()) == nlohmann::json::array())
    std::filesystem::remove(file, ignored);
  std::filesystem::remove(undone, ignored);  // unless something is in it
}

}  // namespace

Status StageCropModel(const BuiltModel& built, const std::filesystem::path& models_folder) {
  return StoreModel(built, UndoneModels(models_folder));
}

Result<bool> SyncCropModels(const AnnotationProject& project) {
  const AnnotationDocument& document = project.document();
  const std::filesystem::path folder = project.Resolve(document.models);
  if (folder.empty()) return false;
  const std::filesystem::path undone = UndoneModels(folder);
  bool changed = false;
  for (const Crop& crop : document.crops) {
    if (crop.into != Crop::Into::kModel || !HasModel(undone, crop.id)) continue;
    // Where both have it, an undo was cut short: they are the same.
    if (const Status moved = MoveModel(crop.id, undone, folder); !moved.ok()) return moved.error();
    changed = true;
  }
  for (const std::string& id : project.ForgottenModels()) {
    const bool used =
        std::any_of(document.instances.begin(), document.instances.end(),
                    [&](const AnnotatedInstance& instance) { return instance.model == id; });
    if (used || !HasModel(folder, id)) continue;
    if (const Status moved = MoveModel(id, folder, undone); !moved.ok()) return moved.error();
    changed = true;
  }
  RemoveIfEmpty(undone);
  return changed;
}

}  // namespace plumbline
