// SPDX-License-Identifier: Apache-2.0
#include "tests/support/program_run.h"

#include <sys/wait.h>

#include <array>
#include <cstdio>

#include "tests/support/test_data.h"

namespace plumbline {

ProgramRun RunProgram(const std::string& arguments, const std::filesystem::path& folder) {
  const std::string there = folder.empty() ? "" : "cd '" + folder.string() + "' && ";
  ProgramRun run;
  FILE* pipe = popen((there + "'" + ProgramFile().string() + "' " + arguments).c_str(), "r");
  if (pipe == nullptr) return run;
  std::array<char, 4096> buffer;
  while (const std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    run.output.append(buffer.data(), n);
  const int status = pclose(pipe);
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  return run;
}

}  // namespace plumbline
