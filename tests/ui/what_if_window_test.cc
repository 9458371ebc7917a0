// SPDX-License-Identifier: Apache-2.0
// Forks a real run in the real window, and looks at both.

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
#include "tests/support/report_bytes.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

class WhatIfWindow : public testing::Test {
 protected:
  void SetUp() override {
    auto display = VirtualDisplay::Start(1600, 1000);
    if (!display.ok()) GTEST_SKIP() << display.error().message;
    display_ = std::move(display).value();
    WriteDrawnSequence(folder_.path() / "sequence", {.frames = 30});
  }
  std::string File(const std::string& name) const { return (folder_.path() / name).string(); }
  int Plumbline(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.path().string() +
                                "' && DISPLAY=" + display_->name() + " timeout 200 '" +
                                ProgramFile().string() + "' " + arguments + " >output.txt 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  int Window(const std::string& steps, const std::string& arguments) const {
    std::ofstream(File("script.json")) << "{\"steps\": [" << steps << "]}";
    return Plumbline("gui " + arguments + " --size 1600x1000 --ui-scale 1 --script script.json");
  }
  nlohmann::json State(const std::string& name) const {
    const auto state = ReadJson(File(name));
    EXPECT_TRUE(state.ok()) << ReadFile(File("output.txt")).value();
    return state.ok() ? *state : nlohmann::json::object();
  }

  TemporaryFolder folder_;
  std::unique_ptr<VirtualDisplay> display_;
};

TEST_F(WhatIfWindow, ForksARunAndShowsBothOnOneClock) {
  ASSERT_EQ(Plumbline("run sequence --out run.plb --seed 3"), 0) << *ReadFile(File("output.txt"));
  ASSERT_EQ(Window(R"(
      {"wait_for": {"frame": 12}},
      {"click": "what_if.title"},
      {"wait_frames": 2},
      {"click": "what_if.fork"},
      {"wait_for": {"fork_sheet": true}},
      {"click": "fork.filter"}, {"text": "alpha"}, {"wait_frames": 2},
      {"click": "fork.option.alpha"}, {"key": "a", "control": true}, {"text": "1"},
      {"key": "enter"}, {"wait_frames": 2},
      {"click": "fork.start"},
      {"wait_for": {"fork": "done", "other_frame": 12, "compared_frame": 12}, "timeout_s": 150},
      {"wait_frames": 3},
      {"dump_state": "beside.json"},
      {"key": "right", "times": 10},
      {"wait_for": {"frame": 22, "other_frame": 22, "compared_frame": 22}},
      {"dump_state": "later.json"},
      {"key": "v"},
      {"wait_for": {"shows_other": true}},
      {"click": "what_if.blink"},
      {"wait_for": {"shows_other": false}},
      {"wait_for": {"shows_other": true}},
      {"click": "what_if.close"},
      {"wait_for": {"other_run": ""}},
      {"dump_state": "closed.json"})",
                   "run.plb --frame 12"),
            0)
      << *ReadFile(File("output.txt"));
  const nlohmann::json beside = State("beside.json");
  EXPECT_EQ(beside["fork_sheet"], false) << "it closes once the fork is done";
  EXPECT_EQ(beside["run_shown"], "beside");
  ASSERT_EQ(beside["other_settings"].size(), 1u) << beside["other_settings"];
  EXPECT_THAT(beside["other_settings"][0].get<std::string>(), testing::HasSubstr("alpha: 2.5 / 1"));
  EXPECT_TRUE(beside["widgets"].contains("other.image.view"));
  EXPECT_TRUE(State("later.json")["widgets"].contains("what_if.row.0"));
  EXPECT_EQ(State("closed.json")["run_shown"], "first");

  const auto run = RunReader::Open(File("run.plb")).value();
  const auto fork = RunReader::Open(File("run-fork-1.plb")).value();
  ASSERT_EQ(fork->NumFrames().value(), 30);
  EXPECT_EQ(fork->header().recipe.seed, 3u);
  EXPECT_EQ(BytesOf(fork->ReadFrame(12).value()), BytesOf(run->ReadFrame(12).value()));
  EXPECT_NE(BytesOf(fork->LastFrame().value()), BytesOf(run->LastFrame().value()));
}

TEST_F(WhatIfWindow, ChangesAndForksARunThatIsBeingMapped) {
  ASSERT_EQ(Window(R"(
      {"wait_for": {"frame": 10}},
      {"key": "p", "control": true},
      {"wait_for": {"palette": true}},
      {"wait_frames": 3},
      {"text": "change options"}, {"wait_frames": 2}, {"key": "enter"},
      {"wait_for": {"fork_sheet": true}},
      {"click": "fork.filter"}, {"text": "alpha"}, {"wait_frames": 2},
      {"click": "fork.option.alpha"}, {"key": "a", "control": true}, {"text": "1"},
      {"key": "enter"}, {"wait_frames": 2},
      {"screenshot": "sheet.png"},
      {"click": "options.apply"},
      {"wait_for": {"fork_sheet": false}},
      {"key": "right"},
      {"wait_for": {"frame": 11, "option_changes": ["11: alpha 2.5 -> 1.0"]}},
      {"key": "b"},
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 21}},
      {"key": "left", "shift": true},
      {"wait_for": {"frame": 11}},
      {"key": "left"},
      {"wait_for": {"frame": 10}},
      {"click": "what_if.title"},
      {"wait_frames": 2},
      {"click": "what_if.fork"},
      {"wait_for": {"fork_sheet": true}},
      {"click": "fork.start"},
      {"wait_for": {"fork": "done", "other_frame": 10, "compared_frame": 10}, "timeout_s": 150},
      {"dump_state": "forked.json"})",
                   "sequence --frame 10 --seed 3 --out live.plb"),
            0)
      << *ReadFile(File("output.txt"));
  // At frame 10 the run had its first options: the fork, unchanged, is the run as it would have
  // been.
  const auto live = RunReader::Open(File("live.plb")).value();
  const auto fork = RunReader::Open(File("live-fork-1.plb")).value();
  EXPECT_EQ(fork->NumFrames().value(), 30);
  EXPECT_EQ(live->NumFrames().value(), 22);
  EXPECT_TRUE(std::filesystem::exists(File("live.plb.bookmarks.json")));
  EXPECT_EQ(BytesOf(fork->ReadFrame(10).value()), BytesOf(live->ReadFrame(10).value()));
  EXPECT_NE(BytesOf(fork->ReadFrame(21).value()), BytesOf(live->ReadFrame(21).value()));
  EXPECT_THAT(State("forked.json")["other_settings"].dump(),
              testing::HasSubstr("first run, from frame 11: alpha 2.5 -> 1.0"));

  // What the window left is resumed with the options that it had come to.
  ASSERT_EQ(Plumbline("run sequence --out live.plb --seed 3 --resume"), 0)
      << *ReadFile(File("output.txt"));
  ASSERT_EQ(Plumbline("run sequence --out same.plb --seed 3 --fork live.plb --at 10 --set alpha=1"),
            0)
      << *ReadFile(File("output.txt"));
  const auto same = RunReader::Open(File("same.plb")).value();
  const auto resumed = RunReader::Open(File("live.plb")).value();
  ASSERT_EQ(resumed->NumFrames().value(), 30);
  EXPECT_EQ(BytesOf(same->LastFrame().value()), BytesOf(resumed->LastFrame().value()));
}

}  // namespace
}  // namespace plumbline
