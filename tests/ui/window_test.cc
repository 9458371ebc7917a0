// SPDX-License-Identifier: Apache-2.0
// Drives the real window on a private display, through scripts, and looks at the state it leaves.

#include <sys/wait.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "app/platform/virtual_display.h"
#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using nlohmann::json;

class Window : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    auto display = VirtualDisplay::Start(2048, 1200);
    if (display.ok()) display_ = std::move(display).value();
  }
  static void TearDownTestSuite() { display_.reset(); }

  void SetUp() override {
    if (display_ == nullptr) GTEST_SKIP() << "Xvfb is not installed; the window is not tested";
  }

  std::string File(const std::string& name) const { return (folder_.path() / name).string(); }

  /// Runs the steps (JSON, between the brackets of a list) after the first frame is there, in the
  /// temporary folder; the exit code.
  int Run(const std::string& steps, const std::string& arguments = "", bool wait = true) {
    const std::string first = wait ? R"({"wait_for": {"frame": 0}},)" : "";
    std::ofstream(File("script.json")) << "{\"steps\": [" << first << steps << "]}";
    const std::string program = (ProgramFile().parent_path() / "fake_window").string();
    const std::string command =
        "cd '" + folder_.path().string() + "' && DISPLAY=" + display_->name() + " timeout 60 '" +
        program + "' --frames 60 --image 240 125 --size 1200 800 --script script.json " +
        arguments + " 2>errors.txt";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  json State(const std::string& name) const {
    const auto state = ReadJson(File(name));
    EXPECT_TRUE(state.ok()) << ReadFile(File("errors.txt")).value();
    return state.ok() ? *state : json::object();
  }

  TemporaryFolder folder_;
  static inline std::unique_ptr<VirtualDisplay> display_;
};

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

TEST_F(Window, TurnsMovesAndZoomsTheMap) {
  ASSERT_EQ(Run(R"(
      {"dump_state": "0.json"},
      {"drag": "scene.view", "from": [0.5, 0.5], "to": [0.6, 0.6]},
      {"dump_state": "1.json"},
      {"drag": "scene.view", "from": [0.5, 0.5], "to": [0.6, 0.5], "button": "right"},
      {"dump_state": "2.json"},
      {"drag": "scene.view", "from": [0.5, 0.5], "to": [0.4, 0.5], "shift": true},
      {"dump_state": "3.json"},
      {"wheel": "scene.view", "amount": 2},
      {"dump_state": "4.json"},
      {"key": "r"},
      {"wait_frames": 3},
      {"dump_state": "5.json"})"),
            0);
  const auto camera = [&](int i) { return State(std::to_string(i) + ".json")["camera"]; };
  EXPECT_LT(camera(1)["azimuth_deg"], camera(0)["azimuth_deg"]);
  EXPECT_GT(camera(1)["elevation_deg"], camera(0)["elevation_deg"]);
  EXPECT_EQ(camera(1)["focus"], camera(0)["focus"]);
  EXPECT_EQ(camera(2)["azimuth_deg"], camera(1)["azimuth_deg"]);
  EXPECT_NE(camera(2)["focus"], camera(1)["focus"]);
  EXPECT_NEAR(camera(3)["focus"][0], camera(1)["focus"][0], 1e-6) << "moved back by the same way";
  EXPECT_NEAR(camera(4)["distance_m"].get<double>(),
              0.88 * 0.88 * camera(3)["distance_m"].get<double>(), 1e-9);
  EXPECT_EQ(camera(5), camera(0));
}

TEST_F(Window, SelectsObjectsAndFramesThem) {
  ASSERT_EQ(Run(R"(
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 10}},
      {"wait_frames": 2},
      {"click": "objects.row.3"},
      {"key": "f"},
      {"wait_frames": 2},
      {"dump_state": "selected.json"},
      {"click": "scene.view", "at": [0.5, 0.5]},
      {"wait_frames": 2},
      {"dump_state": "picked.json"},
      {"key": "escape"},
      {"wait_frames": 2},
      {"dump_state": "cleared.json"},
      {"click": "masks.view", "at": [0.49, 0.36]},
      {"wait_frames": 2},
      {"dump_state": "in_image.json"})"),
            0);
  EXPECT_EQ(State("selected.json")["selected_object"], 3);
  const json focus = State("selected.json")["camera"]["focus"];
  EXPECT_NEAR(focus[0], -0.2, 0.2);
  EXPECT_NEAR(focus[1], 0.85, 0.2);
  EXPECT_GT(State("picked.json")["selected_object"], 0);
  EXPECT_LE(State("cleared.json")["selected_object"], 0);
  EXPECT_GT(State("in_image.json")["selected_object"], 0);
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

TEST_F(Window, RemembersLayoutAndSwitches) {
  const std::string settings = "--settings settings.json";
  ASSERT_EQ(Run(R"(
      {"click": "scene.truth"},
      {"drag": "split.columns", "from": [0.5, 0.5], "to": [20, 0.5]},
      {"click": "image.names"},
      {"dump_state": "first.json"})",
                settings),
            0);
  ASSERT_EQ(Run(R"(
      {"dump_state": "second.json"})",
                settings),
            0);
  const json first = State("first.json"), second = State("second.json");
  EXPECT_GT(first["layout"]["columns"], 0.47);
  EXPECT_EQ(first["layout"], second["layout"]);
  EXPECT_EQ(second["panels"]["scene"]["truth"], true);
  EXPECT_EQ(second["panels"]["image"]["names"], false);
}

TEST_F(Window, RendersTheMapOnlyWhenSomethingChanged) {
  ASSERT_EQ(Run(R"(
      {"wait_frames": 5},
      {"dump_state": "before.json"},
      {"wait_frames": 60},
      {"dump_state": "after.json"})"),
            0);
  EXPECT_EQ(State("before.json")["scene_renders"], State("after.json")["scene_renders"]);
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

TEST_F(Window, KeepsEveryControlInsideTheWindow) {
  for (const auto& [width, height] : {std::pair{1024, 700}, {1600, 1000}, {2048, 1200}}) {
    ASSERT_EQ(Run(R"(
      {"resize": [)" +
                  std::to_string(width) + ", " + std::to_string(height) + R"(]},
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 10}},
      {"wait_frames": 3},
      {"dump_state": "state.json"},
      {"screenshot": "window.png"})"),
              0);
    const json state = State("state.json");
    ASSERT_EQ(state["window"], json({width, height}));
    for (const auto& [name, rect] : state["widgets"].items()) {
      if (name.starts_with("objects.row")) continue;  // rows scroll
      EXPECT_GE(rect[0], 0) << name;
      EXPECT_GE(rect[1], 0) << name;
      EXPECT_LE(rect[2], width) << name;
      EXPECT_LE(rect[3], height) << name;
    }
    const cv::Mat picture = cv::imread(File("window.png"));
    ASSERT_EQ(picture.size(), cv::Size(width, height));
  }
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

TEST_F(Window, LooksFromTheAxesAndThroughTheCamera) {
  ASSERT_EQ(Run(R"(
      {"key": "4"},
      {"wait_frames": 2},
      {"dump_state": "right.json"},
      {"key": "0"},
      {"wait_for": {"look_through": true}},
      {"wait_frames": 2},
      {"screenshot": "through.png", "of": "scene.view"},
      {"key": "r"},
      {"wait_for": {"look_through": false}})"),
            0)
      << ReadFile(File("errors.txt")).value();
  EXPECT_NEAR(State("right.json")["camera"]["azimuth_deg"], 0, 1e-6);
  const cv::Mat through = cv::imread(File("through.png"));
  ASSERT_FALSE(through.empty());
  // The made-up image fills the middle of the view, from side to side or from top to bottom.
  EXPECT_GT(cv::mean(through(cv::Rect(through.cols / 3, through.rows / 3, through.cols / 3,
                                      through.rows / 3)))[1],
            60);
}

TEST_F(Window, TurnsLightAndRemembersIt) {
  const std::string settings = "--settings settings.json";
  ASSERT_EQ(Run(R"(
      {"key": "l", "control": true},
      {"wait_for": {"light": true}},
      {"wait_frames": 3},
      {"screenshot": "light.png"})",
                settings),
            0);
  ASSERT_EQ(Run(R"({"wait_for": {"light": true}})", settings), 0);
  EXPECT_GT(cv::mean(cv::imread(File("light.png")))[1], 120);
}

TEST_F(Window, GrowsItsTextOnDemand) {
  ASSERT_EQ(Run(R"(
      {"key": "=", "control": true},
      {"wait_frames": 2},
      {"dump_state": "larger.json"},
      {"key": "-", "control": true},
      {"wait_frames": 2},
      {"dump_state": "same.json"})",
                "--scale 1"),
            0);
  EXPECT_NEAR(State("larger.json")["ui_scale"], 1.1, 1e-9);
  EXPECT_NEAR(State("same.json")["ui_scale"], 1.0, 1e-9);
}

TEST_F(Window, FilmsEveryLayoutIntoPicturesVideoAndGif) {
  const std::string program = (ProgramFile().parent_path() / "fake_window").string();
  const auto film = [&](const std::string& layout, const std::string& out) {
    return std::system(("cd '" + folder_.path().string() + "' && DISPLAY=" + display_->name() +
                        " timeout 60 '" + program + "' --frames 20 --image 240 125 --size 640 480" +
                        " --layout " + layout + " --film " + out + " 2>>errors.txt")
                           .c_str());
  };
  for (const char* layout :
       {"inspect", "image", "map", "through", "insets", "column", "truth", "flow"}) {
    ASSERT_EQ(film(layout, layout), 0) << layout << ReadFile(File("errors.txt")).value();
    for (const char* frame : {"000000.png", "000002.png", "000004.png"}) {
      const cv::Mat picture = cv::imread(File(std::string(layout) + "/" + frame));
      ASSERT_EQ(picture.size(), cv::Size(640, 480)) << layout;
      cv::Scalar mean, spread;
      cv::meanStdDev(picture, mean, spread);
      EXPECT_GT(spread[1], 10) << layout << " is not empty";
    }
  }
  ASSERT_EQ(film("insets", "film.mp4"), 0);
  EXPECT_GT(std::filesystem::file_size(File("film.mp4")), 1000u);
  if (std::system("command -v ffmpeg >/dev/null") != 0) GTEST_SKIP() << "no ffmpeg: no GIF";
  ASSERT_EQ(film("map", "film.gif"), 0);
  EXPECT_EQ(ReadFile(File("film.gif")).value().substr(0, 4), "GIF8");
}

TEST_F(Window, ShowsOneToFiveImageViewsOfTheUsersChoice) {
  const std::string settings = "--settings settings.json";
  ASSERT_EQ(Run(R"(
      {"dump_state": "five.json"},
      {"click": "image.title"},
      {"wait_frames": 3},
      {"click": "views.count.2"},
      {"wait_frames": 3},
      {"click": "edges.title"},
      {"wait_frames": 3},
      {"click": "views.place.masks"},
      {"wait_frames": 3},
      {"wheel": "masks.view", "amount": 3},
      {"dump_state": "two.json"})",
                settings),
            0);
  const json five = State("five.json"), two = State("two.json");
  for (const char* panel : {"image", "edges", "depth", "masks", "particles"})
    EXPECT_TRUE(five["widgets"].contains(std::string("panel.") + panel)) << panel;
  EXPECT_TRUE(two["widgets"].contains("panel.masks"));
  EXPECT_FALSE(two["widgets"].contains("panel.edges"));
  EXPECT_GT(two["image_zoom"], 1.0) << "both zoom together";
  ASSERT_EQ(Run(R"({"dump_state": "again.json"})", settings), 0);
  EXPECT_EQ(State("again.json")["image_views"], two["image_views"]) << "remembered";
}

TEST_F(Window, SavesAPanelAsAPicture) {
  ASSERT_EQ(Run(R"(
      {"wait_frames": 3},
      {"click": "scene.title", "button": "right"},
      {"wait_frames": 10},
      {"dump_state": "state.json"})"),
            0);
  const cv::Mat picture = cv::imread(File("plumbline-scene-001.png"));
  const auto rect = State("state.json")["widgets"]["panel.scene"];
  ASSERT_FALSE(picture.empty());
  EXPECT_NEAR(picture.cols, rect[2].get<double>() - rect[0].get<double>(), 1.5);
  EXPECT_NEAR(picture.rows, rect[3].get<double>() - rect[1].get<double>(), 1.5);
}

TEST_F(Window, PresentsUntilAKeyAndLeavesEverythingAsItWas) {
  ASSERT_EQ(Run(R"(
      {"click": "scene.scan"},
      {"wait_frames": 2},
      {"dump_state": "before.json"},
      {"key": "f5"},
      {"wait_for": {"presenting": true, "state": "playing", "loop": true}},
      {"wait_for": {"shot": 1}, "timeout_s": 20},
      {"dump_state": "during.json"},
      {"key": "space"},
      {"wait_for": {"presenting": false, "state": "paused"}},
      {"dump_state": "after.json"})"),
            0);
  const json before = State("before.json"), during = State("during.json"),
             after = State("after.json");
  EXPECT_FALSE(during["widgets"].contains("timeline.play")) << "no controls";
  EXPECT_NE(during["panels"]["image"], before["panels"]["image"]);
  EXPECT_EQ(after["panels"], before["panels"]);
  EXPECT_EQ(after["loop"], false);
  EXPECT_EQ(after["window"], before["window"]);
}

TEST_F(Window, RefusesAScriptThatItDoesNotUnderstand) {
  EXPECT_EQ(Run(R"(
      {"click": "no.such.control"})"),
            1);
  EXPECT_THAT(ReadFile(File("errors.txt")).value(), testing::HasSubstr("no.such.control"));
}

}  // namespace
}  // namespace plumbline
