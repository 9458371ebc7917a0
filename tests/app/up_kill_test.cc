// SPDX-License-Identifier: Apache-2.0
// 200 times a random node of a working graph is killed at a random moment.
#include <signal.h>

#include <chrono>
#include <cstdlib>
#include <map>
#include <thread>

#include <gmock/gmock.h>

#include "engine/base/random.h"
#include "tests/app/graph_run.h"

namespace plumbline {
namespace {

class UpKill : public GraphRun {
 protected:
  UpKill() : GraphRun(60) {}

  std::vector<std::string> Map(const std::string& out) const {
    return {Path("sequence"), "--out", Path(out), "--seed", "3", "--edges", "gradient"};
  }
};

TEST_F(UpKill, TheRunIsTheSameAfterEveryKill) {
  const char* wanted = std::getenv("PLUMBLINE_UP_KILLS");
  const int most = wanted != nullptr ? std::atoi(wanted) : 200;
  std::vector<std::string> run = {"run"}, up = {"up", "paper"};
  for (const std::string& word : Map("one.plb")) run.push_back(word);
  for (const std::string& word : Map("killed.plb")) up.push_back(word);
  ASSERT_EQ(Run(run), 0) << Output();
  const auto seed = std::chrono::steady_clock::now().time_since_epoch().count();
  Random random({.seed = static_cast<std::uint64_t>(seed)});
  std::map<std::string, int> kills;
  int done = 0, graphs = 0;
  for (; done < most; ++graphs) {
    const pid_t process = Start(up);
    while (IsRunning(process)) {
      std::this_thread::sleep_for(std::chrono::microseconds(random.Index(2000000)));
      const std::vector<pid_t> children = ChildrenOf(process);
      if (children.empty() || done >= most) continue;
      const pid_t child = children[random.Index(static_cast<std::uint32_t>(children.size()))];
      const std::string command = CommandOf(child);
      const std::size_t kind = command.find(" node ");
      if (kind == std::string::npos || kill(child, SIGKILL) != 0) continue;
      ++kills[command.substr(kind + 6, command.find(' ', kind + 6) - kind - 6)];
      ++done;
    }
    ASSERT_EQ(WaitFor(process), 0) << Output() << "\nkills: " << testing::PrintToString(kills);
    ASSERT_EQ(Difference("one.plb", "killed.plb"), "")
        << Output() << "\nkills: " << testing::PrintToString(kills);
    std::filesystem::remove(Path("killed.plb"));
  }
  std::printf("%d graphs, kills: %s\n", graphs, testing::PrintToString(kills).c_str());
}

}  // namespace
}  // namespace plumbline
