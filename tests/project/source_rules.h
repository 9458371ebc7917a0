// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace plumbline {

/// What one file of the source tree does that the project's layers do not allow, one sentence each,
/// with the line. The rules are listed in CONTRIBUTING.md, "Who may include whom"; this is what
/// holds them.
///
/// @param path     Below the source tree, with '/': it decides which rules apply.
/// @param content  The whole file.
std::vector<std::string> SourceViolations(std::string_view path, std::string_view content);

}  // namespace plumbline
