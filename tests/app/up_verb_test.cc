// SPDX-License-Identifier: Apache-2.0
// Modules as processes: the same run as in one process, whatever dies on the way.
#include <signal.h>

#include <chrono>
#include <cstdio>
#include <map>
#include <sstream>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "engine/base/file_lock.h"
#include "engine/base/files.h"
#include "engine/base/random.h"
#include "engine/mapping/map_report.h"
#include "engine/nodes/run_mirror.h"
#include "engine/recording/run_file.h"
#include "tests/app/graph_run.h"
#include "tests/support/tiny_network.h"

namespace plumbline {
namespace {

constexpr int kFrames = 40;

class UpVerb : public GraphRun {
 protected:
  UpVerb() : GraphRun(kFrames) {}

  std::vector<std::string> Arguments(const std::string& verb, const std::string& out,
                                     const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {verb};
    if (verb == "up") arguments.emplace_back("paper");
    for (const std::string& word : {Path("sequence"), std::string("--out"), Path(out),
                                    std::string("--seed"), std::string("3")})
      arguments.push_back(word);
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
};

TEST_F(UpVerb, MapsAsOneProcessDoesBitForBit) {
  ASSERT_EQ(Run(Arguments("run", "one.plb")), 0) << Output();
  ASSERT_EQ(Run(Arguments("up", "five.plb", {"--json", Path("result.json")})), 0) << Output();
  EXPECT_EQ(Difference("one.plb", "five.plb"), "");
  EXPECT_EQ(FramesIn("five.plb"), kFrames);
  const nlohmann::json result = ReadJson(Path("result.json")).value();
  EXPECT_EQ(result.at("frames"), kFrames);
  EXPECT_TRUE(result.at("restarts").empty()) << result;
}

TEST_F(UpVerb, AlsoWhereEdgesAreComputedAndFramesAreLeftOut) {
  const std::vector<std::string> more = {"--edges", "gradient", "--frames", "3:31:2"};
  ASSERT_EQ(Run(Arguments("run", "one.plb", more)), 0) << Output();
  ASSERT_EQ(Run(Arguments("up", "five.plb", more)), 0) << Output();
  EXPECT_EQ(Difference("one.plb", "five.plb"), "");
  EXPECT_EQ(FramesIn("five.plb"), 14);
}

TEST_F(UpVerb, AlsoWhereNetworksFindEdgesAndScoreBoxes) {
  // Sees a chair in every cell of its grids.
  WriteTinyNetwork(Path("chairs.onnx"), {.kind = NetworkKind::kYolov8,
                                         .width = 96,
                                         .height = 96,
                                         .categories = 80,
                                         .best_category = 56});
  ASSERT_EQ(Run({"networks", "check", Path("chairs.onnx"), "--write"}), 0) << Output();
  const std::vector<std::string> more = {"--detector",   Path("chairs.onnx"), "--edges",
                                         "builtin-half", "--frames",          "0:8"};
  ASSERT_EQ(Run(Arguments("run", "one.plb", more)), 0) << Output();
  ASSERT_EQ(Run(Arguments("up", "five.plb", more)), 0) << Output();
  EXPECT_EQ(Difference("one.plb", "five.plb"), "");
  const FrameReport last = RunReader::Open(Path("five.plb")).value()->LastFrame().value();
  EXPECT_FALSE(last.proposals.empty());
  EXPECT_FALSE(last.objects.empty()) << "nothing was scored";
}

TEST_F(UpVerb, AFrameThatCannotBeReadIsSkippedAsInOneProcess) {
  const std::vector<std::string> few = {"--frames", "0:18"};
  ASSERT_TRUE(WriteFileAtomically(Path("sequence/color/000012.jpg"), "no image").ok());
  ASSERT_TRUE(WriteFileAtomically(Path("sequence/proposals/000015.json"), "no boxes").ok());
  ASSERT_EQ(Run(Arguments("run", "one.plb", few)), 0) << Output();
  ASSERT_EQ(Run(Arguments("up", "five.plb", few)), 0) << Output();
  EXPECT_EQ(Difference("one.plb", "five.plb"), "");
  EXPECT_FALSE(RunReader::Open(Path("five.plb")).value()->ReadFrame(12).value().skipped.empty());
}

TEST_F(UpVerb, OneLineOfTheGraphSaysWhatRunsWhere) {
  const std::vector<std::string> few = {"--frames", "0:12"};
  nlohmann::json graph = ReadJson(SourceDirectory() / "assets/graphs/paper.json").value();
  graph["nodes"][3].erase("edges");      // the mapper finds edges by itself
  graph["nodes"][3].erase("proposals");  // and takes recorded boxes from the player
  graph["nodes"].erase(2);
  graph["nodes"].erase(1);
  ASSERT_TRUE(WriteJson(Path("three.json"), graph).ok());
  ASSERT_EQ(Run(Arguments("run", "one.plb", few)), 0) << Output();
  auto arguments = Arguments("up", "three.plb", few);
  arguments[1] = Path("three.json");
  ASSERT_EQ(Run(arguments), 0) << Output();
  EXPECT_EQ(Difference("one.plb", "three.plb"), "");
}

TEST_F(UpVerb, EachNodeKilledAtRandomItEndsWithTheSameRun) {
  ASSERT_EQ(Run(Arguments("run", "one.plb")), 0) << Output();
  const auto seed = std::chrono::steady_clock::now().time_since_epoch().count();
  Random random({.seed = static_cast<std::uint64_t>(seed)});
  std::map<std::string, int> kills;
  const pid_t up = Start(Arguments("up", "killed.plb", {"--folder", Path("graph")}));
  const std::vector<std::string> kinds = {"player", "edges", "detector", "mapper", "recorder"};
  for (std::size_t turn = 0; IsRunning(up) && kills.size() < kinds.size() && turn < 200; ++turn) {
    std::this_thread::sleep_for(std::chrono::microseconds(random.Index(150000)));
    const std::string& kind = kinds[turn % kinds.size()];
    if (FramesIn("killed.plb") == 0 || kills.contains(kind)) continue;
    for (const pid_t child : ChildrenOf(up)) {
      if (CommandOf(child).find(" node " + kind + " ") == std::string::npos) continue;
      if (kill(child, SIGKILL) == 0) ++kills[kind];
    }
  }
  ASSERT_EQ(WaitFor(up), 0) << Output();
  EXPECT_GE(kills.size(), 3u) << "it was over too soon";
  EXPECT_THAT(Output(), testing::HasSubstr("starting it again"));
  EXPECT_EQ(Difference("one.plb", "killed.plb"), "") << Output();
}

TEST_F(UpVerb, InterruptedItKeepsWhatIsDoneAndGoesOnInOneProcessOrSeveral) {
  ASSERT_EQ(Run(Arguments("run", "one.plb")), 0) << Output();
  const pid_t up = Start(Arguments("up", "stopped.plb"));
  while (IsRunning(up) && FramesIn("stopped.plb") < 5)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  kill(up, SIGINT);
  EXPECT_EQ(WaitFor(up), 1) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("--resume"));
  const int done = FramesIn("stopped.plb");
  EXPECT_GE(done, 5);
  EXPECT_LT(done, kFrames);
  std::filesystem::copy_file(Path("stopped.plb"), Path("alone.plb"));
  ASSERT_EQ(Run(Arguments("up", "stopped.plb", {"--resume"})), 0) << Output();
  EXPECT_EQ(Difference("one.plb", "stopped.plb"), "");
  ASSERT_EQ(Run(Arguments("run", "alone.plb", {"--resume"})), 0) << Output();
  EXPECT_EQ(Difference("one.plb", "alone.plb"), "");
}

TEST_F(UpVerb, WhatCannotWorkIsSaidInTheNodesOwnSentence) {
  EXPECT_EQ(
      Run(Arguments("up", "none.plb", {"--detector", Path("none.onnx"), "--folder", Path("a")})),
      1);
  EXPECT_THAT(Output(), testing::HasSubstr("none.onnx"));
  EXPECT_EQ(Run({"up", "paper", Path("nothing"), "--out", Path("none.plb"), "--folder", Path("b")}),
            1);
  EXPECT_THAT(Output(), testing::HasSubstr("nothing"));
  EXPECT_FALSE(std::filesystem::exists(Path("none.plb")));
  EXPECT_EQ(Run(Arguments("up", "none.plb", {"--poses", "vio"})), 1);
  EXPECT_THAT(Output(), testing::HasSubstr("as the graph paper_vio has it"));
}

TEST_F(UpVerb, ARunningGraphTellsHowItIs) {
  const pid_t up = Start(Arguments("up", "seen.plb", {"--folder", Path("graph")}));
  while (IsRunning(up) && FramesIn("seen.plb") < 3)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  ASSERT_EQ(std::system(("'" + ProgramFile().string() + "' graph '" + Path("graph") + "' --json '" +
                         Path("state.json") + "' --dot '" + Path("state.dot") + "' > '" +
                         Path("state.txt") + "'")
                            .c_str()),
            0);
  ASSERT_EQ(WaitFor(up), 0) << Output();
  const std::string drawing = ReadFile(Path("state.dot")).value();
  EXPECT_THAT(drawing, testing::StartsWith("digraph"));
  EXPECT_THAT(drawing, testing::HasSubstr("\"player\" -> \"mapper\""));
  const nlohmann::json state = ReadJson(Path("state.json")).value();
  ASSERT_EQ(state.at("nodes").size(), 5u);
  for (const nlohmann::json& node : state.at("nodes")) {
    ASSERT_TRUE(node.at("answers").get<bool>()) << node.dump(1);
    EXPECT_EQ(node.at("served").at("refused").at("malformed"), 0);
    const nlohmann::json& clock = node.at("clock");  // ours
    EXPECT_LE(std::abs(clock.at("offset_ms").get<double>()),
              clock.at("uncertainty_ms").get<double>() + 1);
  }
  EXPECT_GT(state.at("nodes")[0].at("served").at("images_shared").get<int>(), 0);
  EXPECT_EQ(state.at("nodes")[0].at("served").at("images_sent"), 0);
  EXPECT_THAT(ReadFile(Path("state.txt")).value(), testing::HasSubstr("mapped "));
}

TEST_F(UpVerb, ACopyThatIsKeptElsewhereIsTheRun) {
  const pid_t up = Start(Arguments("up", "five.plb", {"--folder", Path("graph")}));
  while (IsRunning(up) && !ReadGraph(Path("graph/graph.json")).ok())
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  const auto plan = ReadGraph(Path("graph/graph.json"));
  ASSERT_TRUE(plan.ok()) << Output();
  auto copy = RunMirror::Start(*plan, "viewer", Path("copy.plb"), WorkContext());
  ASSERT_TRUE(copy.ok()) << copy.error().message;
  while (IsRunning(up) && FramesIn("copy.plb") < 5)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  for (const pid_t child : ChildrenOf(up)) {
    if (CommandOf(child).find(" node recorder ") != std::string::npos) kill(child, SIGKILL);
  }
  ASSERT_EQ(WaitFor(up), 0) << Output();
  EXPECT_THAT(Output(), testing::HasSubstr("starting it again"));
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (FramesIn("copy.plb") < kFrames && std::chrono::steady_clock::now() < patience)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  copy->reset();
  // The small pictures are compressed once more.
  EXPECT_EQ(Difference("five.plb", "copy.plb", Pictures::kLeaveOut), "");
}

TEST_F(UpVerb, ACopyEndsWithAGraphThatIsStopped) {
  const pid_t up = Start(Arguments("up", "five.plb", {"--folder", Path("graph")}));
  while (IsRunning(up) && !ReadGraph(Path("graph/graph.json")).ok())
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  const auto plan = ReadGraph(Path("graph/graph.json"));
  ASSERT_TRUE(plan.ok()) << Output();
  const auto copy = RunMirror::Start(*plan, "viewer", Path("copy.plb"), WorkContext());
  ASSERT_TRUE(copy.ok()) << copy.error().message;
  while (IsRunning(up) && FramesIn("copy.plb") < 3)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  EXPECT_TRUE(FileLock::IsHeld(Path("copy.plb")));
  kill(up, SIGTERM);
  EXPECT_NE(WaitFor(up), 0);
  const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (FileLock::IsHeld(Path("copy.plb")) && std::chrono::steady_clock::now() < patience)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_FALSE(FileLock::IsHeld(Path("copy.plb"))) << "it does not wait for more";
  const int frames = FramesIn("copy.plb");
  EXPECT_EQ(frames, FramesIn("five.plb"));
  EXPECT_LT(frames, kFrames) << "this test needs a graph that is slower";
}

/// python3 with the three packages that the example needs, and protoc; "" where they are missing.
std::string ThirdPartyPython(const std::string& schema_folder) {
  const std::string make = "protoc --proto_path='" +
                           (SourceDirectory() / "engine/transport").string() + "' --python_out='" +
                           schema_folder + "' plumbline.proto && PYTHONPATH='" + schema_folder +
                           "' /usr/bin/python3 -c 'import numpy, zmq, plumbline_pb2' 2> /dev/null";
  return std::system(make.c_str()) == 0 ? "/usr/bin/python3" : "";
}

TEST_F(UpVerb, WhoLooksOnGetsTheNewestMapAndDisturbsNobody) {
  std::filesystem::create_directories(Path("schema"));
  const std::string python = ThirdPartyPython(Path("schema"));
  if (python.empty()) GTEST_SKIP() << "python3 with numpy, zmq and protobuf is not here";
  ASSERT_EQ(Run(Arguments("run", "one.plb")), 0) << Output();
  const pid_t up = Start(Arguments("up", "seen.plb", {"--folder", Path("graph")}));
  const std::string follow = "PYTHONPATH='" + Path("schema") + "' timeout 60 " + python + " '" +
                             (SourceDirectory() / "python/plumbline_node/follow.py").string() +
                             "' 'ipc://" + Path("graph/mapper") + "' 5 > '" + Path("seen.txt") +
                             "'";
  // It may come first; and it goes in the middle.
  ASSERT_EQ(std::system(follow.c_str()), 0);
  ASSERT_EQ(WaitFor(up), 0) << Output();
  EXPECT_EQ(Difference("one.plb", "seen.plb"), "");
  std::istringstream lines(ReadFile(Path("seen.txt")).value());
  int frame = 0, objects = 0, dropped = 0, last = -1, num = 0;
  for (std::string line; std::getline(lines, line); ++num) {
    ASSERT_EQ(std::sscanf(line.c_str(), "frame %d: %d objects, %d reports passed over", &frame,
                          &objects, &dropped),
              3)
        << line;
    EXPECT_EQ(frame, last + 1 + dropped) << "what was passed over is counted";
    last = frame;
  }
  EXPECT_EQ(num, 5);
}

TEST_F(UpVerb, AnotherProgramsDetectorReplacesOurs) {
  std::filesystem::create_directories(Path("schema"));
  const std::string python = ThirdPartyPython(Path("schema"));
  if (python.empty()) GTEST_SKIP() << "python3 with numpy, zmq and protobuf is not here";
  nlohmann::json graph = ReadJson(SourceDirectory() / "assets/graphs/paper.json").value();
  const std::string script = (SourceDirectory() / "python/plumbline_node/detector.py").string();
  graph["nodes"][2] = {
      {"name", "detector"},
      {"kind", "other"},
      {"images", "player"},
      {"command",
       {"env", "PYTHONPATH=" + Path("schema"), python, script, "{endpoint}", "{images}"}}};
  ASSERT_TRUE(WriteJson(Path("graph.json"), graph).ok());
  const auto run = [&](const std::string& out) {
    auto arguments = Arguments("up", out, {"--folder", Path(out + " graph")});
    arguments[1] = Path("graph.json");
    return Start(arguments);
  };
  ASSERT_EQ(WaitFor(run("theirs.plb")), 0) << Output();
  const auto reader = RunReader::Open(Path("theirs.plb")).value();
  EXPECT_EQ(ToText(*reader->header().recipe.detector), "process:detector");
  ASSERT_EQ(reader->NumFrames().value(), kFrames);
  int boxes = 0;
  for (int i = 0; i < kFrames; ++i) {
    for (const ProposalReport& proposal : reader->ReadFrame(i).value().proposals) {
      EXPECT_EQ(proposal.category, "chair");
      EXPECT_FLOAT_EQ(proposal.score, 0.6f);
      ++boxes;
    }
  }
  EXPECT_GT(boxes, kFrames / 2);
  // It may die, too.
  const pid_t up = run("killed.plb");
  while (IsRunning(up) && FramesIn("killed.plb") < 5)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  for (const pid_t child : ChildrenOf(up))
    if (CommandOf(child).find("detector.py") != std::string::npos) kill(child, SIGKILL);
  ASSERT_EQ(WaitFor(up), 0) << Output();
  EXPECT_EQ(Difference("theirs.plb", "killed.plb"), "");
}

}  // namespace
}  // namespace plumbline
