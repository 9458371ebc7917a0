// SPDX-License-Identifier: Apache-2.0
// Drives the real window through scripts: time, opening, the palette; looks at the state it leaves.

#include <chrono>

#include <gmock/gmock.h>

#include "tests/support/tiny_sequence.h"
#include "tests/ui/window_fixture.h"

namespace plumbline {
namespace {

using nlohmann::json;

TEST_F(Window, PlaysAndPausesByKeyAndByButton) {
  ASSERT_EQ(Run(R"(
      {"key": "space"},
      {"wait_for": {"frame": {"min": 3}}},
      {"dump_state": "playing.json"},
      {"key": "space"},
      {"wait_for": {"state": "paused"}},
      {"click": "timeline.play"},
      {"wait_for": {"state": "playing"}},
      {"click": "timeline.play"},
      {"wait_for": {"state": "paused"}})"),
            0);
  EXPECT_EQ(State("playing.json")["state"], "playing");
}

TEST_F(Window, StepsAndJumpsByKeys) {
  ASSERT_EQ(Run(R"(
      {"key": "right"},
      {"wait_for": {"frame": 1}},
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 11}},
      {"key": "left", "times": 2},
      {"wait_for": {"frame": 9}},
      {"key": "home"},
      {"wait_for": {"frame": 0}},
      {"key": "end"},
      {"wait_for": {"frame": 11, "newest_frame": 11}},
      {"key": "]"},
      {"wait_for": {"speed": 2.0}},
      {"key": "[", "times": 2},
      {"wait_for": {"speed": 0.5}})"),
            0);
}

TEST_F(Window, FollowsTheMapperAndLooksBackMeanwhile) {
  ASSERT_EQ(Run(R"(
      {"key": "n"},
      {"wait_for": {"frame": {"min": 4}, "follow_newest": true}},
      {"key": "left", "times": 2},
      {"wait_for": {"follow_newest": false, "mapping": true}},
      {"dump_state": "past.json"},
      {"wait_for": {"newest_frame": 59}},
      {"dump_state": "later.json"},
      {"key": "end"},
      {"wait_for": {"frame": 59, "mapping": false, "state": "finished"}})",
                "--slow 30"),
            0)
      << ReadFile(File("errors.txt")).value();
  EXPECT_EQ(State("past.json")["frame"], State("later.json")["frame"])
      << "what is shown stays while the mapper goes on";
}

TEST_F(Window, GoesToATypedFrameNumber) {
  ASSERT_EQ(Run(R"(
      {"key": "g"},
      {"wait_frames": 3},
      {"text": "17"},
      {"key": "enter"},
      {"wait_for": {"frame": 17, "seeking": false}},
      {"double_click": "timeline.frame"},
      {"text": "4"},
      {"key": "enter"},
      {"wait_for": {"frame": 4}},
      {"key": "right"},
      {"wait_for": {"frame": 5}})"),
            0)
      << ReadFile(File("errors.txt")).value();
}

TEST_F(Window, LoopsInASubRange) {
  ASSERT_EQ(Run(R"(
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 10}},
      {"key": "o"},
      {"key": "left", "times": 4},
      {"wait_for": {"frame": 6}},
      {"key": "i"},
      {"wait_for": {"range": [6, 10]}},
      {"key": "space"},
      {"wait_for": {"state": "paused", "frame": 10}},
      {"click": "timeline.loop"},
      {"wait_for": {"loop": true}},
      {"key": "space"},
      {"wait_for": {"frame": 6}},
      {"wait_for": {"frame": 10}},
      {"wait_for": {"frame": 7, "state": "playing"}},
      {"key": "space"},
      {"click": "timeline.in"},
      {"click": "timeline.out"},
      {"wait_for": {"range": [-1, -1]}})"),
            0)
      << ReadFile(File("errors.txt")).value();
}

TEST_F(Window, KeepsBookmarksBesideTheRun) {
  const std::string run = "--recorded --open some.plb";
  ASSERT_EQ(Run(R"(
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 10}},
      {"click": "timeline.bookmarks"},
      {"wait_frames": 3},
      {"text": "sits too far back"},
      {"key": "enter"},
      {"wait_frames": 2},
      {"key": "home"},
      {"wait_for": {"frame": 0}},
      {"key": "b"},
      {"wait_frames": 2},
      {"dump_state": "first.json"})",
                run),
            0)
      << ReadFile(File("errors.txt")).value();
  ASSERT_TRUE(std::filesystem::exists(File("some.plb.bookmarks.json")));
  ASSERT_EQ(Run(R"({"dump_state": "second.json"})", run), 0);
  const json bookmarks = State("second.json")["bookmarks"];
  EXPECT_EQ(bookmarks, State("first.json")["bookmarks"]);
  ASSERT_EQ(bookmarks.size(), 2u);
  EXPECT_EQ(bookmarks[0]["frame"], 0);
  EXPECT_EQ(bookmarks[1]["note"], "sits too far back");
}

TEST_F(Window, SeeksByTheTimeline) {
  ASSERT_EQ(Run(R"(
      {"click": "timeline.track", "at": [0.5, 0.6]},
      {"wait_for": {"seeking": false, "frame": {"min": 25}}},
      {"wait_frames": 5},
      {"dump_state": "middle.json"},
      {"drag": "timeline.track", "from": [0.5, 0.6], "to": [0.1, 0.6]},
      {"wait_frames": 20},
      {"dump_state": "back.json"})"),
            0);
  EXPECT_NEAR(State("middle.json")["frame"].get<int>(), 30, 1);
  EXPECT_NEAR(State("back.json")["frame"].get<int>(), 6, 2);
  EXPECT_EQ(State("back.json")["newest_frame"], State("middle.json")["newest_frame"]);
}

TEST_F(Window, SaysThatPosesLackAndFindsThem) {
  WriteTinySequence(File("poseless"));
  std::filesystem::remove(File("poseless") + "/trajectory.txt");
  WriteText(File("poseless") + "/imu.csv", "0,0,0,0,0,0,9.81\n");
  ASSERT_EQ(Run(R"(
      {"wait_for": {"lacks_poses": true}},
      {"wait_frames": 3},
      {"dump_state": "lacks.json"},
      {"click": "welcome.find_poses"},
      {"wait_for": {"open": true, "frame": 0}},
      {"dump_state": "found.json"})",
                "--open poseless", false),
            0);
  EXPECT_FALSE(State("lacks.json")["open"]);
  EXPECT_FALSE(State("found.json")["lacks_poses"]);
  std::filesystem::remove(File("poseless") + "/imu.csv");
  ASSERT_EQ(Run(R"(
      {"wait_for": {"lacks_poses": true}},
      {"wait_frames": 3},
      {"dump_state": "without_imu.json"})",
                "--open poseless", false),
            0);
  EXPECT_FALSE(State("without_imu.json")["widgets"].contains("welcome.find_poses"));
}

TEST_F(Window, WhatLacksBesidesPosesIsSaidInTheirPlace) {
  WriteTinySequence(File("modelless"));
  std::filesystem::remove_all(File("modelless") + "/models");
  std::filesystem::remove(File("modelless") + "/trajectory.txt");
  WriteText(File("modelless") + "/imu.csv", "0,0,0,0,0,0,9.81\n");
  ASSERT_EQ(Run(R"(
      {"wait_for": {"lacks_poses": true}},
      {"wait_frames": 3},
      {"click": "welcome.find_poses"},
      {"wait_for": {"lacks_poses": false, "message": "'modelless' has no models"}},
      {"wait_frames": 3},
      {"dump_state": "modelless.json"})",
                "--open modelless", false),
            0);
  const nlohmann::json state = State("modelless.json");
  EXPECT_EQ(state["state"], "failed");
  EXPECT_TRUE(state["widgets"].contains("welcome.networks")) << "the remedy";
  EXPECT_FALSE(state["widgets"].contains("welcome.find_poses"));
}

TEST_F(Window, ShowsAndHidesTheHelpSheet) {
  ASSERT_EQ(Run(R"(
      {"key": "f1"},
      {"wait_for": {"help": true}},
      {"key": "escape"},
      {"wait_for": {"help": false}},
      {"key": "?", "shift": true},
      {"wait_for": {"help": true}},
      {"wait_frames": 2},
      {"click": "help.close"},
      {"wait_for": {"help": false}})"),
            0);
}

TEST_F(Window, DoesNotWaitForTheMapper) {
  // The first frame takes 30 s; the window answers meanwhile.
  const auto start = std::chrono::steady_clock::now();
  ASSERT_EQ(Run(R"(
      {"wait_for": {"open": true}},
      {"wait_frames": 10},
      {"click": "scene.truth"},
      {"key": "f1"},
      {"wait_for": {"help": true}},
      {"dump_state": "state.json"})",
                "--slow 30000", false),
            0);
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(25));
  EXPECT_EQ(State("state.json")["frame"], -1);
  EXPECT_EQ(State("state.json")["panels"]["scene"]["truth"], true);
}

TEST_F(Window, SurvivesAFailureAndSaysWhatItWas) {
  ASSERT_EQ(Run(R"(
      {"key": "space"},
      {"wait_for": {"state": "failed"}},
      {"dump_state": "failed.json"},
      {"key": "home"},
      {"wait_for": {"frame": 0}})",
                "--fail 4"),
            0);
  EXPECT_THAT(State("failed.json")["message"].get<std::string>(),
              testing::HasSubstr("cannot be read"));
  EXPECT_EQ(State("failed.json")["frame"], 3);
}

TEST_F(Window, OpensSomethingElse) {
  ASSERT_EQ(Run(R"(
      {"wait_frames": 2},
      {"open": "missing"},
      {"wait_for": {"state": "failed", "open": false}},
      {"open": "room"},
      {"wait_for": {"frame": 0, "open": true}})"),
            0);
}

TEST_F(Window, FindsActionsInThePalette) {
  ASSERT_EQ(Run(R"(
      {"key": "p", "control": true},
      {"wait_for": {"palette": true}},
      {"wait_frames": 3},
      {"text": "ten on"},
      {"wait_frames": 2},
      {"key": "enter"},
      {"wait_for": {"palette": false, "frame": 10}},
      {"key": "p", "control": true},
      {"wait_frames": 3},
      {"text": "7"},
      {"key": "enter"},
      {"wait_for": {"frame": 7}},
      {"key": "p", "control": true},
      {"wait_frames": 3},
      {"text": "select #2"},
      {"wait_frames": 2},
      {"click": "palette.entry.0"},
      {"wait_for": {"selected_object": 2, "palette": false}},
      {"key": "p", "control": true},
      {"wait_for": {"palette": true}},
      {"key": "escape"},
      {"wait_for": {"palette": false, "selected_object": 2}})"),
            0)
      << ReadFile(File("errors.txt")).value();
}

TEST_F(Window, PresentsUntilAKeyAndLeavesEverythingAsItWas) {
  ASSERT_EQ(Run(R"(
      {"click": "scene.scan"},
      {"key": "right", "times": 9},
      {"wait_for": {"frame": 9}},
      {"drag": "scene.view", "from": [0.5, 0.5], "to": [0.6, 0.55]},
      {"wheel": "scene.view", "amount": 2},
      {"wheel": "image.view", "amount": 3},
      {"wait_frames": 4},
      {"dump_state": "before.json"},
      {"key": "f5"},
      {"wait_for": {"presenting": true, "state": "playing", "loop": true}},
      {"wait_for": {"shot": 1}, "timeout_s": 20},
      {"dump_state": "during.json"},
      {"key": "space"},
      {"wait_for": {"presenting": false, "state": "paused", "frame": 9}},
      {"wait_frames": 4},
      {"dump_state": "after.json"})"),
            0);
  const json before = State("before.json"), during = State("during.json"),
             after = State("after.json");
  EXPECT_FALSE(during["widgets"].contains("timeline.play")) << "no controls";
  EXPECT_NE(during["panels"]["image"], before["panels"]["image"]);
  EXPECT_EQ(after["panels"], before["panels"]);
  EXPECT_EQ(after["loop"], false);
  EXPECT_EQ(after["window"], before["window"]);
  for (const char* what : {"frame", "camera", "image_zoom", "selected_object", "layout", "follow",
                           "look_through", "maximized", "confirmed_only"})
    EXPECT_EQ(after[what], before[what]) << what;
}

TEST_F(Window, PausesForTheQuestionWhatIf) {
  ASSERT_EQ(Run(R"(
      {"key": "space"},
      {"wait_for": {"state": "playing"}},
      {"click": "what_if.title"},
      {"wait_frames": 2},
      {"click": "what_if.fork"},
      {"wait_for": {"fork_sheet": true, "state": "paused"}},
      {"key": "escape"},
      {"wait_for": {"fork_sheet": false, "state": "paused"}})"),
            0)
      << ReadFile(File("errors.txt")).value();
}

TEST_F(Window, OpenedForTheDemoModeEndsWithItByAnyKey) {
  for (const char* key : {"space", "escape", "q", "f5"}) {
    ASSERT_EQ(Run(std::string(R"(
      {"wait_for": {"presenting": true, "frame": {"min": 2}}},
      {"wait_frames": 5},
      {"key": ")") + key +
                      R"("},
      {"wait_for": {"frame": -2}})",
                  "--demo --settings settings.json", false),
              0)
        << key << ReadFile(File("errors.txt")).value();
  }
  ASSERT_EQ(Run(R"({"dump_state": "later.json"})", "--settings settings.json"), 0);
  ASSERT_EQ(Run(R"({"dump_state": "plain.json"})"), 0);
  EXPECT_EQ(State("later.json")["panels"], State("plain.json")["panels"])
      << "what the demo showed is not kept";
}

TEST_F(Window, OpensWhatIsDroppedOntoIt) {
  std::filesystem::create_directories(File("chairs"));
  std::ofstream(File("chairs/models.json")) << "{}";
  std::ofstream(File("scan.ply"))
      << "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
         "property float z\nend_header\n0 0 0\n";
  ASSERT_EQ(Run(R"(
      {"drop": ["other room"]},
      {"wait_for": {"source": "other room", "frame": 0}},
      {"key": "right"}, {"wait_for": {"frame": 1}},
      {"drop": ["run.plb"]},
      {"wait_for": {"source": "run.plb", "frame": 0}},
      {"key": "right", "times": 3}, {"wait_for": {"frame": 3}},
      {"drop": ["chairs"]},
      {"wait_for": {"source": "run.plb", "models": "chairs", "frame": 3}},
      {"drop": ["missing"]},
      {"wait_for": {"state": "failed", "open": false}},
      {"drop": ["scan.ply"]},
      {"wait_for": {"workspace": "annotate"}},
      {"wait_frames": 3},
      {"drop": ["run.plb"]},
      {"wait_for": {"workspace": "inspect", "source": "run.plb", "frame": 0}})"),
            0)
      << ReadFile(File("errors.txt")).value();
  EXPECT_EQ(ReadFile(File("models.txt")).value(), "chairs");
}

TEST_F(Window, RefusesAScriptThatItDoesNotUnderstand) {
  EXPECT_EQ(Run(R"(
      {"click": "no.such.control"})"),
            1);
  EXPECT_THAT(ReadFile(File("errors.txt")).value(), testing::HasSubstr("no.such.control"));
}

}  // namespace
}  // namespace plumbline
