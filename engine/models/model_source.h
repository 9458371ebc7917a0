// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include <Eigen/Geometry>

#include "engine/base/result.h"

namespace plumbline {

/// `object` from the axes of the mesh file that a model was built from, in metres, by name, of the
/// models of DIR/models.json whose `source` tells it (`up`, `front`, `origin_m`: those that `models
/// build` made). Errors: kNotFound, kCorrupt, kInvalidInput, naming file and model.
Result<std::map<std::string, Eigen::Isometry3d, std::less<>>> ReadObjectFromFile(
    const std::filesystem::path& folder);

}  // namespace plumbline
