// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/base/result.h"

namespace plumbline {

/// Whether models.json of the folder names a model; false where there is none to read.
bool HasModel(const std::filesystem::path& folder, const std::string& name);

/// Takes a model (entry, mesh, texture) from one database into another, which is made if there is
/// none; one of the same name there is replaced. At any moment at least one of them has it whole,
/// so a process may end at any moment, and the move be made again. Errors: kNotFound (no such
/// model), kIo, kCorrupt.
Status MoveModel(const std::string& name, const std::filesystem::path& from,
                 const std::filesystem::path& to);

}  // namespace plumbline
