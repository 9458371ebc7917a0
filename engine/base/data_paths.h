// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "engine/base/result.h"

namespace plumbline {

/// From now on names in data files may lead out of the folder of the file (`--allow-outside`).
void AllowOutside();

/// The file that a data file in `folder` names: relative, and without leading out of the folder by
/// "..", unless AllowOutside was called. Links are followed: they are not in the data file.
/// Errors: kInvalidInput; a sentence whose subject is the name.
Result<std::filesystem::path> PlaceInside(const std::filesystem::path& folder,
                                          const std::string& name);

/// Whether a file of this name, with an ending behind it, lies in the folder it is written to.
bool IsFileName(const std::string& name);

}  // namespace plumbline
