// SPDX-License-Identifier: Apache-2.0
// The real window attaches to a graph that is mapping, and lets it go on.
#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "app/platform/virtual_display.h"
#include "engine/base/files.h"
#include "tests/app/graph_run.h"

namespace plumbline {
namespace {

constexpr int kFrames = 150;

class AttachWindow : public GraphRun {
 protected:
  AttachWindow() : GraphRun(kFrames) {}

  void SetUp() override {
    auto display = VirtualDisplay::Start(1600, 1000);
    if (!display.ok()) GTEST_SKIP() << display.error().message;
    display_ = std::move(display).value();
  }

  int Window(const std::string& steps, const std::string& arguments) const {
    std::ofstream(Path("script.json")) << "{\"steps\": [" << steps << "]}";
    const std::string command = "cd '" + folder_.path().string() +
                                "' && DISPLAY=" + display_->name() + " timeout 300 '" +
                                ProgramFile().string() + "' gui " + arguments +
                                " --size 1600x1000 --ui-scale 1 --script script.json "
                                ">window.txt 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  nlohmann::json State(const std::string& name) const {
    const auto state = ReadJson(Path(name));
    EXPECT_TRUE(state.ok()) << ReadFile(Path("window.txt")).value();
    return state.ok() ? *state : nlohmann::json::object();
  }

  std::unique_ptr<VirtualDisplay> display_;
};

TEST_F(AttachWindow, FollowsTheRunLooksBackAndComesToItsEnd) {
  const pid_t up =
      Start({"up", "paper", Path("sequence"), "--out", Path("run.plb"), "--folder", Path("graph")});
  while (IsRunning(up) && !std::filesystem::exists(Path("graph/graph.json")))
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  ASSERT_EQ(Window(R"(
      {"wait_for": {"nodes_answer": 5, "growing": true}, "timeout_s": 60},
      {"dump_state": "attached.json"},
      {"key": "left", "times": 2},
      {"wait_for": {"follow_newest": false}},
      {"dump_state": "back.json"},
      {"key": "n"},
      {"wait_for": {"growing": false}, "timeout_s": 200},
      {"wait_for": {"state": "finished"}},
      {"dump_state": "end.json"})",
                   "--attach graph"),
            0)
      << ReadFile(Path("window.txt")).value();
  EXPECT_EQ(Window("", "--attach graph --out copy.plb"), 1);
  EXPECT_THAT(ReadFile(Path("window.txt")).value(), testing::HasSubstr("run.plb' here"));
  ASSERT_EQ(WaitFor(up), 0) << Output();
  EXPECT_TRUE(State("attached.json").at("growing").get<bool>());
  EXPECT_TRUE(State("attached.json").at("recorded").get<bool>());
  EXPECT_TRUE(State("back.json").at("growing").get<bool>());
  EXPECT_EQ(State("end.json").at("newest_frame"), kFrames - 1);
  EXPECT_EQ(State("end.json").at("frame"), kFrames - 1) << "N went back to the newest";
  EXPECT_EQ(FramesIn("run.plb"), kFrames) << "nobody was disturbed";
}

TEST_F(AttachWindow, OpensARunningGraphLikeAnythingElse) {
  const pid_t up =
      Start({"up", "paper", Path("sequence"), "--out", Path("run.plb"), "--folder", Path("graph")});
  while (IsRunning(up) && FramesIn("run.plb") < 2)
    std::this_thread::sleep_for(std::chrono::milliseconds(3));
  ASSERT_EQ(Window(R"(
      {"open": "graph"},
      {"wait_for": {"nodes_answer": 5, "growing": true}, "timeout_s": 60},
      {"dump_state": "opened.json"})",
                   ""),
            0)
      << ReadFile(Path("window.txt")).value();
  EXPECT_TRUE(State("opened.json").at("recorded").get<bool>());
  ASSERT_EQ(WaitFor(up), 0) << Output();
  EXPECT_EQ(FramesIn("run.plb"), kFrames) << "nobody was disturbed";
}

TEST_F(AttachWindow, WhatCannotBeAttachedToIsSaid) {
  const auto says = [&](const std::string& arguments) {
    EXPECT_EQ(Window("", arguments), 1) << arguments;
    return ReadFile(Path("window.txt")).value();
  };
  EXPECT_THAT(says("--attach paper"), testing::HasSubstr("is not running"));
  EXPECT_THAT(says("--attach nothing"), testing::HasSubstr("nothing"));
  EXPECT_THAT(says("sequence --attach paper"), testing::HasSubstr("leave out"));
}

}  // namespace
}  // namespace plumbline
