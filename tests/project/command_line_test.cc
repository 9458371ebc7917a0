// SPDX-License-Identifier: Apache-2.0
// What every command owes to scripts: --help that works, and exit code 2 for wrong usage.

#include <regex>
#include <set>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/program_run.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// Those of this build: without the window there is nothing behind `gui` and `render`.
std::set<std::string> Commands() {
  std::istringstream help(RunProgram("--help").output);
  std::set<std::string> commands;
  bool listing = false;
  for (std::string line; std::getline(help, line);) {
    static const std::regex kCommand("^  ([a-z]+)( |$)");
    std::smatch match;
    if (line.starts_with("Subcommands:")) listing = true;
    const bool left_out = line.find("left out of this build") != std::string::npos;
    if (listing && !left_out && std::regex_search(line, match, kCommand)) commands.insert(match[1]);
  }
  return commands;
}

TEST(CommandLine, SaysItsVersionAndExplainsItself) {
  EXPECT_THAT(RunProgram("--version").output, testing::ContainsRegex("[0-9]+\\.[0-9]+\\.[0-9]+"));
  EXPECT_EQ(RunProgram("--help").exit_code, 0);
  EXPECT_THAT(Commands(), testing::IsSupersetOf({"run", "synth", "evaluate", "detect"}));
}

TEST(CommandLine, ExplainsEveryCommand) {
  for (const std::string& command : Commands()) {
    const ProgramRun outcome = RunProgram(command + " --help");
    EXPECT_EQ(outcome.exit_code, 0) << command;
    EXPECT_THAT(outcome.output, HasSubstr("--help")) << command;
  }
}

TEST(CommandLine, ExitsWithTwoOnWrongUsage) {
  EXPECT_EQ(RunProgram("2>&1").exit_code, 2) << "no command";
  EXPECT_EQ(RunProgram("no-such-command 2>&1").exit_code, 2);
  for (const std::string& command : Commands()) {
    const ProgramRun outcome = RunProgram(command + " --no-such-option 2>&1 >/dev/null");
    EXPECT_EQ(outcome.exit_code, 2) << command;
    EXPECT_THAT(outcome.output, Not(IsEmpty())) << command << " does not say what was wrong";
  }
}

}  // namespace
}  // namespace plumbline
