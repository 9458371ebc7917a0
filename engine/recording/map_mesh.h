// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "engine/base/result.h"
#include "engine/evaluation/map_evaluation.h"
#include "engine/geometry/mesh.h"
#include "engine/models/model_database.h"

namespace plumbline {

/// The objects' meshes at their poses, in world coordinates, coloured by object.
/// Errors: kNotFound (a model that the database lacks).
Result<TriangleMesh> MapMesh(std::span<const EstimatedObject> objects,
                             const ModelDatabase& database);

}  // namespace plumbline
