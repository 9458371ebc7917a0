// SPDX-License-Identifier: Apache-2.0
// The list of folders and files, in the real window on real folders.

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/ui/window_fixture.h"

namespace plumbline {
namespace {

class PathDialogWindow : public Window {
 protected:
  void SetUp() override {
    Window::SetUp();
    Put("walk/camera.json", "{}");
    std::filesystem::create_directories(folder_.path() / "walk" / "color");
    Put("models/models.json", "{}");
    Put("old runs/first.plb", "x");
    Put("old runs/first light.plb", "x");
    Put("old runs/second.plb", "x");
    Put("notes.txt", "x");
    Put("table.annotation.json", R"({"plumbline_annotation": 1})");
    Put("other.json", "{}");
    Put(".secret.plb", "x");
  }
  void Put(const std::string& name, const std::string& content) {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name) << content;
  }
  bool Shows(const std::string& state, const std::string& widget) const {
    return State(state)["widgets"].contains(widget);
  }
  std::string Errors() const { return ReadFile(File("errors.txt")).value(); }
};

constexpr const char* kOpen = R"({"key": "o", "control": true},
    {"wait_for": {"path_dialog": true}}, {"wait_frames": 12},)";

TEST_F(PathDialogWindow, ShowsWhatCanBeOpenedAndGoesByTheKeyboard) {
  ASSERT_EQ(Run(std::string(kOpen) + R"(
      {"dump_state": "list.json"},
      {"key": "h", "control": true}, {"wait_frames": 2},
      {"dump_state": "hidden.json"},
      {"text": "o"}, {"key": "enter"}, {"wait_frames": 12},
      {"dump_state": "inside.json"},
      {"key": "backspace"}, {"wait_frames": 12},
      {"dump_state": "above.json"},
      {"key": "down"}, {"key": "enter"},
      {"wait_for": {"path_dialog": false}},
      {"wait_frames": 5},
      {"dump_state": "opened.json"})"),
            0)
      << Errors();
  EXPECT_TRUE(Shows("list.json", "path.row.walk"));
  EXPECT_TRUE(Shows("list.json", "path.row.table.annotation.json"));
  for (const char* left_out : {"notes.txt", "other.json", ".secret.plb"})
    EXPECT_FALSE(Shows("list.json", std::string("path.row.") + left_out)) << left_out;
  EXPECT_TRUE(Shows("hidden.json", "path.row..secret.plb"));
  EXPECT_TRUE(Shows("inside.json", "path.row.second.plb"));
  EXPECT_TRUE(Shows("above.json", "path.row.old runs"));
  // Below "old runs", from which Backspace came.
  EXPECT_EQ(State("opened.json")["recent"][0], File("walk"));
}

TEST_F(PathDialogWindow, CompletesWhatIsTyped) {
  ASSERT_EQ(Run(std::string(kOpen) + R"(
      {"text": "/"}, {"wait_frames": 3}, {"text": ")" +
                folder_.path().string().substr(1) + R"(/ol"}, {"wait_frames": 12},
      {"key": "tab"}, {"wait_frames": 12},
      {"text": "fi"}, {"wait_frames": 3}, {"key": "tab"}, {"wait_frames": 3},
      {"dump_state": "two.json"},
      {"text": " "}, {"wait_frames": 3}, {"key": "tab"}, {"wait_frames": 3},
      {"key": "enter"},
      {"wait_for": {"path_dialog": false}},
      {"wait_frames": 5},
      {"dump_state": "opened.json"})"),
            0)
      << Errors();
  EXPECT_TRUE(Shows("two.json", "path.row.first.plb"));
  EXPECT_FALSE(Shows("two.json", "path.row.second.plb"));
  EXPECT_EQ(State("opened.json")["recent"][0], File("old runs/first light.plb"));
}

TEST_F(PathDialogWindow, EscLeavesEverythingAsItWas) {
  ASSERT_EQ(Run(std::string(kOpen) + R"(
      {"key": "escape"}, {"wait_frames": 3},
      {"dump_state": "closed.json"})"),
            0)
      << Errors();
  EXPECT_EQ(State("closed.json")["path_dialog"], false);
  EXPECT_EQ(State("closed.json")["source"], "made-up room");
}

TEST_F(PathDialogWindow, AsksBeforeItReplaces) {
  Put("picture.png", "precious");
  ASSERT_EQ(Run(R"(
      {"key": "f12", "shift": true},
      {"wait_for": {"path_dialog": true}}, {"wait_frames": 12},
      {"text": "picture"}, {"wait_frames": 3}, {"key": "enter"}, {"wait_frames": 3},
      {"dump_state": "asks.json"},
      {"key": "escape"}, {"wait_frames": 3},
      {"dump_state": "kept.json"},
      {"click": "path.choose"}, {"wait_frames": 3},
      {"click": "path.replace"},
      {"wait_for": {"path_dialog": false}},
      {"wait_frames": 12})"),
            0)
      << Errors();
  EXPECT_TRUE(Shows("asks.json", "path.replaces"));
  EXPECT_EQ(State("kept.json")["path_dialog"], true);
  EXPECT_FALSE(Shows("kept.json", "path.replaces"));
  EXPECT_GT(std::filesystem::file_size(File("picture.png")), 1000u);
}

TEST_F(PathDialogWindow, KeepsWhereItWasAndIsReachedFromThePaletteAndFromFields) {
  ASSERT_EQ(Run(std::string(kOpen) + R"(
      {"text": "o"}, {"key": "enter"}, {"wait_frames": 12},
      {"double_click": "path.row.second.plb", "at": [0.2, 0.5]},
      {"wait_for": {"path_dialog": false, "frame": 0}},
      {"key": "p", "control": true}, {"wait_frames": 3},
      {"text": "open another beside"}, {"wait_frames": 3}, {"key": "enter"},
      {"wait_for": {"path_dialog": true}}, {"wait_frames": 12},
      {"dump_state": "again.json"},
      {"key": "escape"}, {"wait_frames": 3},
      {"key": "p", "control": true}, {"wait_frames": 3},
      {"text": "networks of this run"}, {"wait_frames": 3}, {"key": "enter"}, {"wait_frames": 5},
      {"click": "networks.browse"},
      {"wait_for": {"path_dialog": true}}, {"wait_frames": 12},
      {"key": "escape"}, {"wait_frames": 3},
      {"dump_state": "sheet.json"})",
                "--settings settings.json"),
            0)
      << Errors();
  EXPECT_TRUE(Shows("again.json", "path.row.first.plb"));
  EXPECT_TRUE(Shows("sheet.json", "networks.sheet")) << "Esc is for what lies above";
  EXPECT_EQ(State("settings.json")["places"][0], File("old runs"));
}

TEST_F(PathDialogWindow, FitsASmallWindowWithLargeText) {
  ASSERT_EQ(Run(std::string(R"({"resize": [1024, 640]},)") + kOpen + R"(
      {"dump_state": "small.json"})",
                "--scale 2"),
            0)
      << Errors();
  const nlohmann::json widgets = State("small.json")["widgets"];
  for (const char* name : {"path.title", "path.field", "path.row.walk", "path.remark",
                           "path.hidden", "path.cancel", "path.choose"}) {
    ASSERT_TRUE(widgets.contains(name)) << name;
    EXPECT_GE(widgets[name][0], 0) << name;
    EXPECT_LE(widgets[name][2], 1024) << name;
    EXPECT_LE(widgets[name][3], 640) << name;
  }
  EXPECT_LE(widgets["path.hidden"][2], widgets["path.cancel"][0]);
}

TEST_F(PathDialogWindow, SaysWhichStepOfAScriptIsWrong) {
  EXPECT_NE(Run(R"({"key": "a"}, {"click": 5})"), 0);
  EXPECT_NE(Errors().find("step 3: \"click\" must be a text, but is 5"), std::string::npos)
      << Errors();
  EXPECT_NE(Run(R"({"drag": "panel.scene", "from": [0.1, 0.1]})"), 0);
  EXPECT_NE(Errors().find("step 2: \"drag\" needs \"to\""), std::string::npos) << Errors();
  EXPECT_NE(Run(R"({"wait_for": 3})"), 0);
  EXPECT_NE(Errors().find("step 2: \"wait_for\" must be an object"), std::string::npos) << Errors();
}

}  // namespace
}  // namespace plumbline
