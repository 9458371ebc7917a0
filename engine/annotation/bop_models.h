// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>

#include <nlohmann/json_fwd.hpp>

#include "engine/models/model_database.h"

namespace plumbline {

inline constexpr double kBopUnitsPerMetre = 1000;
/// A place [m] as BOP has it, in millimetres.
nlohmann::json BopVector(const Eigen::Vector3d& v);

/// The folder models/ of a BOP dataset: obj_NNNNNN.ply, models_info.json with diameters, boxes and
/// symmetries, and plumbline_models.json, which keeps our names. Ascii, millimetres, the origin in
/// the middle of the box, with normals and, where the model has them, colours or a texture
/// (obj_NNNNNN.png beside it). obj_id is the place in the database + 1.
/// @param used  Places in the database. Errors: kIo.
Status WriteBopModels(const ModelDatabase& models, const std::set<int>& used,
                      const std::filesystem::path& folder);

}  // namespace plumbline
