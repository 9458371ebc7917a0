// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/base/result.h"

namespace plumbline {

/// Looks for what assimp 5.2 does not survive: it ends the program, or takes memory until there is
/// none. tests/fuzz found all of it; see the table there.
/// @param ending  Of the file's name, in lower case: ".obj".
/// Errors: kCorrupt, naming the file.
Status CheckBeforeAssimp(const std::filesystem::path& file, const std::string& ending);

}  // namespace plumbline
