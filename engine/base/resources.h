// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.h"

namespace plumbline {

/// Files that are built into the program (shaders, fonts, defaults), by their path below the source
/// tree. With the environment variable PLUMBLINE_RESOURCES set to a source tree they are read from
/// there instead, so that shaders can be edited without a build. Errors: kNotFound.
Result<std::string> LoadResource(std::string_view name);

/// Called by generated code (cmake/Embed.cmake) only. The data must live as long as the program.
void RegisterResource(std::string_view name, std::string_view data);

}  // namespace plumbline
