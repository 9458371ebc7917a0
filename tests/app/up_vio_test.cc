// SPDX-License-Identifier: Apache-2.0
// Poses that a node of its own finds: the same run as in one process.
#include <signal.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include <gmock/gmock.h>

#include "engine/base/files.h"
#include "engine/dataset/growing_sequence.h"
#include "engine/recording/run_file.h"
#include "engine/vio/own_pose_report.h"
#include "tests/app/graph_run.h"
#include "tests/support/replayed_recording.h"

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

TEST_F(UpVio, FollowsARecordingWhileItIsMade) {
  ASSERT_EQ(Run({"synth", "--imu", "--rest", "1.5", "--size", "320x240", "--rate", "10", "--frames",
                 "100", "--light-rays", "4", "--out", Path("film")}),
            0);
  const std::vector<std::string> options = {"--live",  "--poses",  "vio",
                                            "--edges", "gradient", "--out"};
  const auto map_while_recording = [&](std::vector<std::string> command, const std::string& out,
                                       bool kill_all) {
    std::filesystem::remove_all(Path("recording"));
    ReplayedRecording recorder(Path("film"), Path("recording"));
    command.push_back(Path("recording"));
    command.insert(command.end(), options.begin(), options.end());
    command.push_back(Path(out));
    const pid_t pid = Start(command);
    for (int image = 1; recorder.Add(1); ++image) {
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      // Each kind once, a second apart, from when there is something to lose.
      static const std::vector<std::string> kKinds = {"recorder", "mapper", "vio",
                                                      "detector", "edges",  "player"};
      if (!kill_all || image < 34 || image % 10 != 4) continue;
      const auto kind = static_cast<std::size_t>(image / 10 - 3);
      for (const pid_t child : ChildrenOf(pid))
        if (kind < kKinds.size() &&
            CommandOf(child).find(" node " + kKinds[kind] + " ") != std::string::npos)
          kill(child, SIGKILL);
    }
    recorder.End();
    ASSERT_EQ(WaitFor(pid), 0) << Output();
    const auto run = RunReader::Open(Path(out)).value();
    EXPECT_EQ(run->header().end_frame, 100) << "as it was in the end";
    EXPECT_GE(FramesIn(out), 1);
    const auto poses = run->ReadOwnPoses().value();
    ASSERT_NE(poses, nullptr);
    EXPECT_EQ(poses->frames.size(), 100u);
    EXPECT_TRUE(poses->frames.back().ready) << poses->frames.back().waits_for;
  };
  map_while_recording({"run"}, "one.plb", false);
  map_while_recording({"up", "paper_vio"}, "six.plb", true);
  for (const char* name : {"recorder", "mapper", "vio", "detector", "edges", "player"})
    EXPECT_THAT(Output(), testing::HasSubstr("the node '" + std::string(name) + "' ")) << "killed";
  // The filter has seen the same in both, whatever was mapped of it.
  const auto one = RunReader::Open(Path("one.plb")).value()->ReadOwnPoses().value();
  const auto six = RunReader::Open(Path("six.plb")).value()->ReadOwnPoses().value();
  for (std::size_t i = 0; i < one->frames.size(); ++i) {
    ASSERT_EQ(one->frames[i].world_from_cam.has_value(), six->frames[i].world_from_cam.has_value());
    if (!one->frames[i].world_from_cam) continue;
    EXPECT_EQ(one->frames[i].world_from_cam->matrix(), six->frames[i].world_from_cam->matrix());
  }
}

TEST_F(UpVio, RecordsACameraAndAnImuWhicheverIsKilled) {
  ASSERT_EQ(Run({"synth", "--imu", "--rest", "1.5", "--size", "320x240", "--rate", "10", "--frames",
                 "80", "--light-rays", "4", "--out", Path("film")}),
            0);
  const std::string played = "play:" + Path("film");
  const pid_t pid =
      Start({"up", "live", Path("walk"), "--camera", played, "--imu", played, "--calibration",
             Path("film"), "--models", Path("film") + "/models", "--edges", "gradient", "--out",
             Path("walk.plb"), "--folder", Path("graph")});
  const auto images = [&] {
    const auto text = ReadFile(Path("walk/color.csv"));
    return text.ok() ? std::count(text->begin(), text->end(), '\n') - 1 : 0;
  };
  const auto kill_node = [&](const std::string& kind, int at_image) {
    while (IsRunning(pid) && images() < at_image)
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    for (const pid_t child : ChildrenOf(pid))
      if (CommandOf(child).find(" node " + kind + " ") != std::string::npos) kill(child, SIGKILL);
  };
  kill_node("camera", 25);
  kill_node("imu", 40);
  kill_node("player", 50);
  ASSERT_EQ(WaitFor(pid), 0) << Output();
  for (const char* name : {"camera", "imu", "player"})
    EXPECT_THAT(Output(), testing::HasSubstr("the node '" + std::string(name) + "' ")) << "killed";
  EXPECT_FALSE(IsBeingRecorded(Path("walk")));
  // What a camera would have given while nobody read it is missing, and nothing else.
  const auto sequence = OpenSequence(Path("walk")).value();
  EXPECT_GE(sequence->num_frames(), 50);
  EXPECT_LT(sequence->num_frames(), 80);
  for (int i = 0; i < sequence->num_frames(); ++i)
    EXPECT_TRUE(sequence->ReadRawImage(i).ok()) << "image " << i;
  for (int i = 1; i < sequence->num_frames(); ++i)
    EXPECT_GT(sequence->stamp_ns(i), sequence->stamp_ns(i - 1));
  const auto readings = sequence->ReadImu().value().samples;
  for (std::size_t i = 1; i < readings.size(); ++i)
    ASSERT_GT(readings[i].stamp_ns, readings[i - 1].stamp_ns);
  const auto run = RunReader::Open(Path("walk.plb")).value();
  EXPECT_EQ(run->header().end_frame, sequence->num_frames());
  const auto poses = run->ReadOwnPoses().value();
  ASSERT_NE(poses, nullptr);
  EXPECT_EQ(static_cast<int>(poses->frames.size()), sequence->num_frames());
}

TEST_F(UpVio, CalibratesWhileItIsRecorded) {
  ASSERT_EQ(Run({"synth", "--imu", "--rest", "1.5", "--size", "320x240", "--rate", "10", "--frames",
                 "60", "--light-rays", "4", "--out", Path("film")}),
            0);
  ReplayedRecording recorder(Path("film"), Path("recording"));
  const pid_t pid = Start({"calibrate", Path("recording"), "--live", "--passes", "2"});
  while (recorder.Add(1)) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  recorder.End();
  ASSERT_EQ(WaitFor(pid), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("0 s: waiting for"));
  EXPECT_THAT(Output(), testing::ContainsRegex("5 s: clocks .* ms; camera turned .* cm"));
  EXPECT_THAT(Output(), testing::HasSubstr("2 backward"));
  EXPECT_NE(Run({"calibrate", Path("recording"), "--live"}), 0);
  EXPECT_THAT(Output(), testing::HasSubstr("nobody records into"));
}

}  // namespace
}  // namespace plumbline
