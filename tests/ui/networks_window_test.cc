// SPDX-License-Identifier: Apache-2.0
// Chooses networks in the real window while a sequence is mapped.

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/platform/virtual_display.h"
#include "engine/base/files.h"
#include "engine/recording/run_file.h"
#include "tests/support/drawn_sequence.h"
#include "tests/support/test_data.h"
#include "tests/support/tiny_network.h"

namespace plumbline {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

class NetworksWindow : public testing::Test {
 protected:
  void SetUp() override {
    auto display = VirtualDisplay::Start(1600, 1000);
    if (!display.ok()) GTEST_SKIP() << display.error().message;
    display_ = std::move(display).value();
    WriteDrawnSequence(folder_.path() / "sequence", {.frames = 12});
    WriteTinyNetwork(File("mine.onnx"), {.kind = NetworkKind::kYolox, .categories = 80});
    std::ofstream(File("wrong.onnx")) << "not a network";
  }
  std::string File(const std::string& name) const { return (folder_.path() / name).string(); }
  /// With nothing fetched.
  int Window(const std::string& steps, const std::string& arguments) const {
    std::ofstream(File("script.json")) << "{\"steps\": [" << steps << "]}";
    const std::string command = "cd '" + folder_.path().string() +
                                "' && XDG_DATA_HOME=none DISPLAY=" + display_->name() +
                                " timeout 200 '" + ProgramFile().string() + "' gui " + arguments +
                                " --size 1600x1000 --ui-scale 1 --script script.json "
                                ">output.txt 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  nlohmann::json State(const std::string& name) const {
    const auto state = ReadJson(File(name));
    EXPECT_TRUE(state.ok()) << ReadFile(File("output.txt")).value();
    return state.ok() ? *state : nlohmann::json::object();
  }
  int FramesOf(const std::string& run) const {
    const auto reader = RunReader::Open(File(run));
    return reader.ok() ? (*reader)->NumFrames().value() : -1;
  }

  TemporaryFolder folder_;
  std::unique_ptr<VirtualDisplay> display_;
};

TEST_F(NetworksWindow, AChoiceMapsAgainAndKeepsTheRecordedRun) {
  ASSERT_EQ(Window(R"(
      {"wait_for": {"frame": 5}},
      {"dump_state": "before.json"},
      {"click": "top.networks"},
      {"wait_for": {"networks_sheet": true}},
      {"wait_frames": 3},
      {"click": "networks.detector.yolox_nano"},
      {"wait_frames": 3},
      {"dump_state": "sheet.json"},
      {"click": "networks.edges.gradient"},
      {"wait_for": {"edges": "gradient", "frame": 0}},
      {"key": "escape"},
      {"wait_for": {"networks_sheet": false}},
      {"key": "right", "times": 2},
      {"wait_for": {"frame": 2}},
      {"dump_state": "after.json"})",
                   "sequence --frame 5 --out run.plb"),
            0)
      << *ReadFile(File("output.txt"));
  EXPECT_EQ(State("before.json")["edges"], "dataset");
  EXPECT_EQ(State("before.json")["detector"], "dataset");
  EXPECT_EQ(State("sheet.json")["detector"], "dataset") << "what is not fetched cannot be chosen";
  EXPECT_EQ(State("sheet.json")["reopening"], "");
  EXPECT_EQ(State("after.json")["detector"], "dataset");
  EXPECT_THAT(State("after.json")["recording"].get<std::string>(), EndsWith("run-2.plb"));
  EXPECT_EQ(FramesOf("run.plb"), 6);
  EXPECT_EQ(FramesOf("run-2.plb"), 3);
}

TEST_F(NetworksWindow, AWrongFileIsToldAndTheRunGoesOn) {
  ASSERT_EQ(Window(R"(
      {"wait_for": {"frame": 5}},
      {"drop": ["wrong.onnx"]},
      {"wait_for": {"networks_sheet": true, "networks.file_known": true}},
      {"wait_frames": 3},
      {"dump_state": "wrong.json"},
      {"key": "escape"},
      {"wait_for": {"networks_sheet": false}},
      {"key": "right"},
      {"wait_for": {"frame": 6}},
      {"dump_state": "on.json"})",
                   "sequence --frame 5"),
            0)
      << *ReadFile(File("output.txt"));
  const nlohmann::json wrong = State("wrong.json");
  EXPECT_THAT(wrong["networks.file_problem"].get<std::string>(), HasSubstr("wrong.onnx"));
  EXPECT_TRUE(wrong["widgets"].contains("networks.problem"));
  EXPECT_FALSE(wrong["widgets"].contains("networks.use"));
  EXPECT_EQ(State("on.json")["newest_frame"], 6);
}

TEST_F(NetworksWindow, BoxesThatAreNotThereAreFoundByTheBuiltInDetector) {
  std::filesystem::remove_all(folder_.path() / "sequence/proposals");
  ASSERT_EQ(Window(R"(
      {"wait_for": {"open": true, "frame": 0, "state": "paused"}},
      {"dump_state": "open.json"})",
                   "sequence"),
            0)
      << *ReadFile(File("output.txt"));
  EXPECT_EQ(State("open.json")["detector"], "builtin");
}

TEST_F(NetworksWindow, AFileOfOnesOwnHelpsWhereAnotherFails) {
  std::filesystem::remove_all(folder_.path() / "sequence/proposals");
  ASSERT_EQ(Window(R"(
      {"wait_for": {"state": "failed"}},
      {"wait_frames": 3},
      {"dump_state": "failed.json"},
      {"click": "welcome.networks"},
      {"wait_for": {"networks_sheet": true, "state": "failed"}},
      {"wait_frames": 3},
      {"click": "networks.file"}, {"text": "mine.onnx"}, {"key": "enter"},
      {"wait_for": {"networks.file_known": true, "networks.file_problem": "",
                    "state": "failed"}},
      {"wait_frames": 3},
      {"dump_state": "looked.json"},
      {"click": "networks.use"},
      {"wait_for": {"open": true, "frame": 0, "state": "paused"}},
      {"dump_state": "open.json"})",
                   "sequence --detector wrong.onnx"),
            0)
      << *ReadFile(File("output.txt"));
  EXPECT_THAT(State("failed.json")["message"].get<std::string>(), HasSubstr("wrong.onnx"));
  const nlohmann::json looked = State("looked.json");
  EXPECT_THAT(looked["networks.file_is"].get<std::string>(), HasSubstr("yolox"));
  EXPECT_EQ(looked["networks.file_guessed"], true);
  EXPECT_THAT(State("open.json")["detector"].get<std::string>(), EndsWith("mine.onnx"));
  EXPECT_TRUE(std::filesystem::exists(File("mine.json"))) << "the guess is kept";
}

}  // namespace
}  // namespace plumbline
