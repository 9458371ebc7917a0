// SPDX-License-Identifier: Apache-2.0
// Drives the real window through scripts: views, layout, theme, pictures.

#include <gmock/gmock.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/ui/window_fixture.h"

namespace plumbline {
namespace {

using nlohmann::json;

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
      {"key": "p", "control": true}, {"wait_frames": 2}, {"text": "#3"}, {"wait_frames": 2},
      {"key": "enter"}, {"wait_frames": 3},
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

TEST_F(Window, KeepsEveryControlInsideTheWindow) {
  for (const auto& [width, height] :
       {std::pair{1024, 640}, {1024, 700}, {1600, 1000}, {2048, 1200}}) {
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

TEST_F(Window, MeasuresInAViewWithoutPerspective) {
  // The first click beside an open menu closes it, and does nothing else.
  ASSERT_EQ(Run(R"(
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 10}},
      {"wait_frames": 2},
      {"click": "scene.layers"}, {"wait_frames": 2},
      {"click": "scene.parallel"},
      {"click": "scene.tape"},
      {"click": "objects.title"}, {"wait_frames": 2},
      {"key": "p", "control": true}, {"wait_frames": 2}, {"text": "#3"}, {"wait_frames": 2},
      {"key": "enter"}, {"wait_frames": 3},
      {"key": "f"},
      {"wait_frames": 3},
      {"dump_state": "framed.json"},
      {"screenshot": "before.png", "of": "scene.view"},
      {"click": "scene.view", "at": [0.4, 0.5]}, {"wait_frames": 2},
      {"click": "scene.view", "at": [0.6, 0.5]}, {"wait_frames": 3},
      {"screenshot": "measured.png", "of": "scene.view"},
      {"click": "scene.layers"}, {"wait_frames": 2},
      {"click": "scene.tape"},
      {"click": "objects.title"}, {"wait_frames": 2},
      {"key": "p", "control": true}, {"wait_frames": 2}, {"text": "#2"}, {"wait_frames": 2},
      {"key": "enter"}, {"wait_frames": 3},
      {"dump_state": "other.json"},
      {"click": "scene.view", "at": [0.5, 0.5]}, {"wait_frames": 2},
      {"dump_state": "picked.json"})"),
            0)
      << ReadFile(File("errors.txt")).value();
  EXPECT_EQ(State("framed.json")["camera"]["parallel"], true);
  EXPECT_EQ(State("other.json")["selected_object"], 2);
  EXPECT_EQ(State("picked.json")["selected_object"], 3) << "what is framed is in the middle";
  const cv::Mat before = cv::imread(File("before.png")),
                measured = cv::imread(File("measured.png"));
  ASSERT_EQ(before.size(), measured.size());
  // The tape lies between the two clicks, which are level; beyond them nothing changed.
  cv::Mat differs;
  cv::absdiff(before, measured, differs);
  cv::reduce(differs.reshape(1), differs, 0, cv::REDUCE_MAX);
  differs = differs.reshape(3);
  const auto changed = [&](double x) {
    const auto at = static_cast<int>(x * differs.cols);
    return cv::norm(differs.colRange(at, at + 3), cv::NORM_INF) > 60;
  };
  EXPECT_TRUE(changed(0.4));
  EXPECT_TRUE(changed(0.6));
  EXPECT_FALSE(changed(0.05));
  EXPECT_FALSE(changed(0.95));
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

TEST_F(Window, APanelFillsTheWindowByADoubleClickOrAKeyAndGoesBack) {
  ASSERT_EQ(Run(R"(
      {"wait_frames": 3},
      {"dump_state": "before.json"},
      {"double_click": "image.title"},
      {"wait_for": {"maximized": "image"}},
      {"wait_frames": 3},
      {"dump_state": "image.json"},
      {"double_click": "image.title"},
      {"wait_for": {"maximized": ""}},
      {"hover": "scene.view"},
      {"key": "m"},
      {"wait_for": {"maximized": "scene"}},
      {"wait_frames": 3},
      {"dump_state": "map.json"},
      {"click": "panel.restore"},
      {"wait_for": {"maximized": ""}},
      {"wait_frames": 3},
      {"dump_state": "after.json"})"),
            0);
  const json before = State("before.json")["widgets"], image = State("image.json")["widgets"],
             map = State("map.json")["widgets"], after = State("after.json")["widgets"];
  const auto width = [](const json& rect) { return rect[2].get<int>() - rect[0].get<int>(); };
  EXPECT_LT(width(before["panel.image"]), 700);
  EXPECT_GT(width(image["panel.image"]), 1150);
  EXPECT_FALSE(image.contains("panel.scene"));
  EXPECT_TRUE(image.contains("panel.timeline")) << "to step through the run";
  EXPECT_GT(width(map["panel.scene"]), 1150);
  EXPECT_EQ(after["panel.image"], before["panel.image"]);
  EXPECT_EQ(after["panel.timings"], before["panel.timings"]);
}

TEST_F(Window, HasBuiltInLayoutsAndOnesOwn) {
  const std::string settings = "--settings layouts.json";
  ASSERT_EQ(Run(R"(
      {"wait_frames": 3},
      {"dump_state": "overview.json"},
      {"click": "top.layout"},
      {"wait_frames": 3},
      {"click": "layout.Images"},
      {"wait_frames": 3},
      {"dump_state": "images.json"},
      {"click": "top.layout"},
      {"wait_frames": 3},
      {"click": "layout.panel.relations"},
      {"wait_frames": 2},
      {"click": "layout.name"},
      {"text": "mine"},
      {"click": "layout.keep"},
      {"wait_frames": 2},
      {"click": "layout.Map"},
      {"wait_frames": 3},
      {"dump_state": "map.json"})",
                settings),
            0);
  ASSERT_EQ(Run(R"(
      {"wait_frames": 3},
      {"dump_state": "again.json"},
      {"click": "top.layout"},
      {"wait_frames": 3},
      {"click": "layout.own.mine"},
      {"wait_frames": 3},
      {"dump_state": "mine.json"},
      {"click": "top.layout"},
      {"wait_frames": 3},
      {"click": "layout.Overview"},
      {"wait_frames": 3},
      {"dump_state": "back.json"})",
                settings),
            0);
  const auto area = [&](const char* file, const char* panel) {
    const json rect = State(file)["widgets"][panel];
    return (rect[2].get<double>() - rect[0].get<double>()) *
           (rect[3].get<double>() - rect[1].get<double>());
  };
  EXPECT_GT(area("images.json", "panel.image"), 1.8 * area("overview.json", "panel.image"));
  EXPECT_GT(area("map.json", "panel.scene"), 1.8 * area("overview.json", "panel.scene"));
  EXPECT_FALSE(State("map.json")["widgets"].contains("panel.timings"));
  EXPECT_EQ(State("again.json")["hidden_panels"], State("map.json")["hidden_panels"]);
  EXPECT_EQ(State("again.json")["own_layouts"], json({"mine"}));
  EXPECT_EQ(area("mine.json", "panel.image"), area("images.json", "panel.image"));
  EXPECT_FALSE(State("mine.json")["widgets"].contains("relations.title")) << "hidden in it";
  EXPECT_TRUE(State("back.json")["widgets"].contains("relations.title"));
  EXPECT_TRUE(State("back.json")["widgets"].contains("panel.timings"));
}

TEST_F(Window, PutsAllListsIntoOnePlaceWhereThereIsLittleRoom) {
  ASSERT_EQ(Run(R"(
      {"resize": [1024, 640]},
      {"wait_frames": 4},
      {"dump_state": "small.json"},
      {"click": "objects.more"},
      {"wait_frames": 3},
      {"click": "tab.timings"},
      {"wait_for": {"compact_tab": "timings"}},
      {"wait_frames": 3},
      {"dump_state": "timings.json"},
      {"resize": [1200, 800]},
      {"wait_frames": 4},
      {"dump_state": "large.json"})"),
            0);
  const json small = State("small.json")["widgets"];
  EXPECT_TRUE(small.contains("panel.image"));
  EXPECT_TRUE(small.contains("panel.scene"));
  EXPECT_TRUE(small.contains("panel.objects"));
  EXPECT_FALSE(small.contains("panel.edges"));
  EXPECT_FALSE(small.contains("panel.timings"));
  EXPECT_TRUE(State("timings.json")["widgets"].contains("panel.timings"));
  const json large = State("large.json")["widgets"];
  for (const char* panel : {"panel.edges", "panel.objects", "panel.details", "panel.timings"})
    EXPECT_TRUE(large.contains(panel)) << panel;
}

TEST_F(Window, ShowsConfirmedObjectsOnlyInAllViews) {
  ASSERT_EQ(Run(R"(
      {"key": "c"},
      {"wait_for": {"confirmed_only": true}},
      {"click": "top.confirmed"},
      {"wait_for": {"confirmed_only": false}})"),
            0);
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

TEST_F(Window, FocusesByDoubleClickFollowsTheCameraAndLetsGo) {
  ASSERT_EQ(Run(R"(
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 10}},
      {"wait_frames": 2},
      {"dump_state": "0.json"},
      {"double_click": "scene.view", "at": [0.5, 0.62]},
      {"wait_frames": 2},
      {"dump_state": "1.json"},
      {"key": "r"}, {"wait_frames": 2},
      {"click": "scene.follow"},
      {"wait_for": {"follow": true}},
      {"wait_frames": 2},
      {"dump_state": "2.json"},
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 20}},
      {"wait_frames": 2},
      {"dump_state": "3.json"},
      {"click": "scene.follow"},
      {"wait_for": {"follow": false}},
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 30}},
      {"wait_frames": 2},
      {"dump_state": "4.json"})"),
            0)
      << ReadFile(File("errors.txt")).value();
  const auto camera = [&](int i) { return State(std::to_string(i) + ".json")["camera"]; };
  EXPECT_NE(camera(1)["focus"], camera(0)["focus"]) << "turns about what was clicked";
  EXPECT_EQ(camera(1)["azimuth_deg"], camera(0)["azimuth_deg"]);
  EXPECT_NE(camera(3), camera(2)) << "moves with the camera";
  EXPECT_EQ(camera(4), camera(3)) << "and stays where it was left";
}

TEST_F(Window, KeepsEverythingInsideOnADesktopThatWantsTwiceTheScale) {
  // GLFW asks the resource database of the X server what the desktop wants.
  auto dense = VirtualDisplay::Start(2048, 1200);
  ASSERT_TRUE(dense.ok());
  const std::string set = "DISPLAY=" + (*dense)->name() +
                          " xprop -root -f RESOURCE_MANAGER 8s -set RESOURCE_MANAGER "
                          "'Xft.dpi: 192\n'";
  if (std::system(("command -v xprop >/dev/null && " + set).c_str()) != 0)
    GTEST_SKIP() << "xprop is not installed (apt-get install x11-utils)";
  std::swap(display_, *dense);
  ASSERT_EQ(Run(R"(
      {"resize": [2048, 1200]},
      {"key": "right", "shift": true},
      {"wait_for": {"frame": 10}},
      {"wait_frames": 3},
      {"dump_state": "state.json"},
      {"screenshot": "window.png"})"),
            0)
      << ReadFile(File("errors.txt")).value();
  std::swap(display_, *dense);
  const json state = State("state.json");
  EXPECT_NEAR(state["ui_scale"], 2, 1e-9);
  for (const auto& [name, rect] : state["widgets"].items()) {
    if (name.starts_with("objects.row")) continue;  // rows scroll
    EXPECT_GE(rect[0], 0) << name;
    EXPECT_GE(rect[1], 0) << name;
    EXPECT_LE(rect[2], 2048) << name;
    EXPECT_LE(rect[3], 1200) << name;
  }
  const json play = state["widgets"]["timeline.play"];
  EXPECT_GE(play[3].get<double>() - play[1].get<double>(), 40) << "twice the size";
}

}  // namespace
}  // namespace plumbline
