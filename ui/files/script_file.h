// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/base/result.h"

namespace plumbline {

/// The steps of a window script, `{"steps": [{"key": "space"}, ...]}`; whoever does them may rely
/// on the types and ranges of their values, not on what the window shows then. docs/panels.md lists
/// the steps. Errors: kNotFound, kCorrupt, kInvalidInput, naming the file, the step by its number
/// and the key.
Result<std::vector<nlohmann::json>> ReadScript(const std::filesystem::path& file);

}  // namespace plumbline
