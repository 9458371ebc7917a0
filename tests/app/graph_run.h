// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/program_process.h"
#include "tests/support/test_data.h"

namespace plumbline {

/// Tests of `up`, whose runs must be those of `run`.
class GraphRun : public testing::Test {
 protected:
  explicit GraphRun(int frames);

  std::string Path(const std::string& name) const { return (folder_.path() / name).string(); }
  /// Starts the program; its output goes to output.txt.
  pid_t Start(std::vector<std::string> arguments) const;
  int Run(std::vector<std::string> arguments) const { return WaitFor(Start(std::move(arguments))); }
  std::string Output() const;
  int FramesIn(const std::string& file) const;

  /// The processes that a process has started.
  static std::vector<pid_t> ChildrenOf(pid_t process);
  /// The arguments that a process was started with, by spaces.
  static std::string CommandOf(pid_t process);

  /// All that differs between two run files, but for times; "" where they are the same, bit for
  /// bit.
  enum class Pictures { kCompare, kLeaveOut };
  std::string Difference(const std::string& one, const std::string& other,
                         Pictures pictures = Pictures::kCompare) const;

  TemporaryFolder folder_;
};

}  // namespace plumbline
