// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "engine/annotation/annotation_project.h"
#include "engine/models/model_builder.h"

namespace plumbline {

// The models that crops make live as long as their crops do. The project and its journal say which
// those are; the database follows. What is not (yet, or any more) a part of it waits in a folder of
// its own, `.undone` in the database's, so that a process may end at any moment.

/// Where a model waits.
std::filesystem::path UndoneModels(const std::filesystem::path& models_folder);

/// Puts the model of a crop where undone ones are, before the edit that makes it. Errors: of
/// StoreModel.
Status StageCropModel(const BuiltModel& built, const std::filesystem::path& models_folder);

/// Brings the database in step with the project: models of its crops come in, those of crops that
/// were undone (or removed) go out, unless an object is of that model. To be called after edits,
/// undo, redo and opening. True if the database changed. Errors: kIo, kCorrupt.
Result<bool> SyncCropModels(const AnnotationProject& project);

}  // namespace plumbline
