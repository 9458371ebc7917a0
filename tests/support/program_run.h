// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace plumbline {

/// What a command said and how it ended.
struct ProgramRun {
  int exit_code = -1;
  std::string output;  ///< Standard output, and what the arguments redirect there.
};

/// Runs the program under test.
/// @param arguments  For a shell.
/// @param folder     Where; empty: here.
ProgramRun RunProgram(const std::string& arguments, const std::filesystem::path& folder = {});

}  // namespace plumbline
