// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "engine/base/result.h"

namespace plumbline {

/// Where a program runs, and for how long.
struct ChildPlace {
  std::filesystem::path folder;  ///< Its working folder.
  std::filesystem::path output;  ///< What it says on both channels is appended here.
  std::optional<double> timeout_s;
};

/// How a program ended.
struct ChildEnd {
  int exit_code = 0;  ///< Of one that ended by itself.
  int signal = 0;     ///< That ended it; 0: none.
  bool timed_out = false;

  bool ok() const { return exit_code == 0 && signal == 0 && !timed_out; }
};

/// Runs a program in a process group of its own and waits for it. When `stop` is requested or the
/// time is over, the group is asked to end (SIGTERM) and, ten seconds later, made to. It does not
/// outlive this process, however that ends.
/// @param words  The program, looked up in PATH if it has no slash, and its arguments.
/// Errors: kIo if it cannot be started; kCancelled.
Result<ChildEnd> RunChild(const std::vector<std::string>& words, const ChildPlace& place,
                          const std::stop_token& stop);

/// "ended with exit code 1", "was ended by signal 11 (Segmentation fault)", "took too long".
std::string InWords(const ChildEnd& end);

/// Words as a shell takes them apart again.
std::string ShellWords(const std::vector<std::string>& words);

}  // namespace plumbline
