// SPDX-License-Identifier: Apache-2.0
// Poses that a node of its own finds: the same run as in one process.
#include <signal.h>

#include <chrono>
#include <thread>

#include <gmock/gmock.h>

#include "engine/recording/run_file.h"
#include "engine/vio/own_pose_report.h"
#include "tests/app/graph_run.h"

namespace plumbline {
namespace {

class UpVio : public GraphRun {
 protected:
  UpVio() : GraphRun(1) {}
};

TEST_F(UpVio, MapsAsOneProcessDoesBitForBitWhoeverIsKilled) {
  ASSERT_EQ(Run({"synth", "--imu", "--rest", "1.5", "--size", "320x240", "--rate", "10", "--frames",
                 "34", "--light-rays", "4", "--out", Path("film")}),
            0);
  const std::vector<std::string> more = {"--poses",  "vio",     "--edges", "gradient",
                                         "--frames", "10:34:3", "--out"};
  std::vector<std::string> run = {"run", Path("film")}, up = {"up", "paper_vio", Path("film")};
  for (auto* arguments : {&run, &up}) arguments->insert(arguments->end(), more.begin(), more.end());
  run.push_back(Path("one.plb"));
  up.insert(up.end(), {Path("six.plb"), "--folder", Path("graph")});
  ASSERT_EQ(WaitFor(Start(run)), 0) << Output();
  const pid_t pid = Start(up);
  // Each of those that know something is killed once it knows it.
  for (const char* kind : {"vio", "mapper"}) {
    while (IsRunning(pid) && FramesIn("six.plb") < 2)
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    for (const pid_t child : ChildrenOf(pid))
      if (CommandOf(child).find(std::string(" node ") + kind + " ") != std::string::npos)
        kill(child, SIGKILL);
  }
  ASSERT_EQ(WaitFor(pid), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("starting it again"));
  EXPECT_EQ(Difference("one.plb", "six.plb"), "");
  EXPECT_EQ(FramesIn("six.plb"), 8);
  const auto poses = RunReader::Open(Path("six.plb")).value()->ReadOwnPoses().value();
  ASSERT_NE(poses, nullptr);
  EXPECT_TRUE(poses->frames.back().ready) << poses->frames.back().waits_for;
}

}  // namespace
}  // namespace plumbline
