// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "engine/base/result.h"
#include "engine/evaluation/map_evaluation.h"
#include "engine/geometry/mesh.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// What tells the objects of a map mesh apart.
enum class MapColors {
  kByObject,
  kOwn  ///< Those of the models; models without are grey.
};

/// The objects' meshes at their poses, in world coordinates.
/// Errors: kNotFound (a model that the database lacks).
Result<TriangleMesh> MapMesh(std::span<const EstimatedObject> objects,
                             const ModelDatabase& database,
                             MapColors colors = MapColors::kByObject);

}  // namespace plumbline
