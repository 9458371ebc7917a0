// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace plumbline {

/// Starts the program under test and does not wait for it; what it says goes into the file
/// `output`.
pid_t StartProgram(std::vector<std::string> arguments, const std::string& output);
/// Exit code of a process; minus the signal that ended it.
int WaitFor(pid_t process);
bool IsRunning(pid_t process);

}  // namespace plumbline
