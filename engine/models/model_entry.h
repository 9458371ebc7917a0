// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "engine/models/model_database.h"

namespace plumbline {

/// One entry of models.json with its mesh; `where` begins its error messages. Errors: kInvalidInput
/// and those of ReadMesh; throws nlohmann::json::exception for values of the wrong type.
Result<CadModel> ReadModelEntry(const nlohmann::json& json, const std::filesystem::path& folder,
                                const std::string& where);

}  // namespace plumbline
