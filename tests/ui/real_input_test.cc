// SPDX-License-Identifier: Apache-2.0
// The way from the X server through GLFW to the panels, with real events that xdotool sends. What
// each control does is tested by scripts in window_test.cc; here only that events arrive, and that
// they do what was meant however long a frame of the window takes.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/platform/virtual_display.h"
#include "engine/base/files.h"
#include "tests/support/annotation_walk.h"
#include "tests/support/test_data.h"

namespace plumbline {
namespace {

using nlohmann::json;

class RealInput : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("command -v xdotool >/dev/null") != 0)
      GTEST_SKIP()
          << "xdotool is not installed; real input is not tested (apt-get install xdotool)";
    auto display = VirtualDisplay::Start(1280, 900);
    if (!display.ok()) GTEST_SKIP() << display.error().message;
    display_ = std::move(display).value();
  }
  void TearDown() override {
    if (window_ > 0) {
      kill(window_, SIGKILL);
      waitpid(window_, nullptr, 0);
    }
  }

  /// In the temporary folder.
  void Start(const std::filesystem::path& program, std::vector<std::string> arguments) {
    window_ = fork();
    if (window_ != 0) return;
    setenv("DISPLAY", display_->name().c_str(), 1);
    setenv("XDG_CONFIG_HOME", folder_.path().c_str(), 1);
    arguments.insert(arguments.begin(), program.string());
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    words.push_back(nullptr);
    if (chdir(folder_.path().c_str()) == 0) execv(program.c_str(), words.data());
    _exit(127);
  }

  json State() const {
    const auto state =
        std::filesystem::exists(state_file_) ? ReadJson(state_file_) : Result<json>(json::object());
    return state.ok() ? *state : json::object();
  }
  /// Polls: how long an event takes depends on what else the machine does.
  template <typename Wanted>
  bool Comes(const Wanted& wanted) const {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (std::chrono::steady_clock::now() < deadline) {
      const json state = State();
      if (!state.empty() && wanted(state)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return false;
  }
  void Do(const std::string& what) const {
    ASSERT_EQ(std::system(("DISPLAY=" + display_->name() + " xdotool " + what).c_str()), 0) << what;
  }
  std::string MouseTo(const std::string& widget, double x = 0.5, double y = 0.5) const {
    const json rect = State()["widgets"][widget];
    if (rect.size() != 4) return "mousemove 0 0";
    const auto at = [](double low, double high, double share) {
      return std::to_string(static_cast<int>(low + share * (high - low)));
    };
    return "mousemove " + at(rect[0], rect[2], x) + " " + at(rect[1], rect[3], y);
  }

  TemporaryFolder folder_;
  std::string state_file_ = (folder_.path() / "state.json").string();
  std::unique_ptr<VirtualDisplay> display_;
  pid_t window_ = -1;
};

TEST_F(RealInput, ReachesTheWindowByKeyboardAndMouse) {
  Start(
      ProgramFile().parent_path() / "fake_window",
      {"--frames", "60", "--image", "240", "125", "--size", "1200", "800", "--state", state_file_});
  ASSERT_TRUE(Comes([](const json& s) { return s["frame"] == 0; })) << "the window did not come up";
  Do("key Right");
  EXPECT_TRUE(Comes([](const json& s) { return s["frame"] == 1; }));
  Do("key shift+Right");
  EXPECT_TRUE(Comes([](const json& s) { return s["frame"] == 11; }));
  Do("key F1");
  EXPECT_TRUE(Comes([](const json& s) { return s["help"] == true; }));
  Do("key Escape");
  EXPECT_TRUE(Comes([](const json& s) { return s["help"] == false; }));
  Do(MouseTo("timeline.play") + " click 1");
  EXPECT_TRUE(Comes([](const json& s) { return s["frame"] > 12; })) << "the button plays";
  Do("key space");
  EXPECT_TRUE(Comes([](const json& s) { return s["state"] == "paused"; }));

  const json before = State()["camera"];
  Do(MouseTo("scene.view") +
     " mousedown 1 mousemove_relative 60 20 mousemove_relative 60 20 "
     "mouseup 1");
  EXPECT_TRUE(Comes([&](const json& s) {
    return s["camera"]["azimuth_deg"] != before["azimuth_deg"];
  })) << "a drag turns the map";
  const double distance_m = State()["camera"]["distance_m"];
  Do(MouseTo("scene.view") + " click 4");
  EXPECT_TRUE(Comes([&](const json& s) { return s["camera"]["distance_m"] < distance_m; }))
      << "the wheel zooms";

  Do("key ctrl+q");
  int status = 0;
  EXPECT_EQ(waitpid(window_, &status, 0), window_);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  window_ = -1;
}

/// `plumbline gui` on a scan, at 60 frames a second and at 5.
class RealAnnotation : public RealInput, public testing::WithParamInterface<int> {
 protected:
  void SetUp() override {
    RealInput::SetUp();
    if (display_ == nullptr) return;
    scene_ = MakeAnnotationScene(folder_.path());
    Start(ProgramFile(), {"gui", "scan.ply", "--size", "1200x800", "--state", state_file_,
                          "--frame-ms", std::to_string(GetParam())});
    ASSERT_TRUE(Comes([](const json& s) {
      return s.value("annotate.aligns", false) && s["annotate.models"] == 5 &&
             s["annotate.busy"] == "";
    })) << "the window did not come up";
    Do("key 5");  // from above: the middle of the view is the origin of the floor
    Rest();
  }
  /// Until what was done has been drawn, with the frames that ImGui takes to come to rest.
  void Rest() const {
    std::this_thread::sleep_for(std::chrono::milliseconds(200 + 6 * GetParam()));
  }
  /// The floor, and an armchair on it.
  void PlaceArmchair() {
    Do(MouseTo("annotate.tool.floor") + " click 1");
    ASSERT_TRUE(Comes([](const json& s) { return s["annotate.tool"] == "floor"; }));
    Do(MouseTo("annotate.view", 0.5, 0.75) + " click 1");
    ASSERT_TRUE(Comes([](const json& s) { return s["annotate.proposal"] == "floor"; }));
    Do("key Return");
    ASSERT_TRUE(Comes([](const json& s) { return s["annotate.floor_known"] == true; }));
    Do("key 5");
    Rest();
    Do(MouseTo("annotate_models.armchair") + " click 1");
    ASSERT_TRUE(Comes([](const json& s) { return s["annotate.tool"] == "place"; }));
    eye_ = Eye();
    Do(MouseTo("annotate.view", 0.59, 0.43) + " click 1");
    ASSERT_TRUE(Comes([](const json& s) {
      return s["annotate.proposal"] == "placement" && s["annotate.running"] == false;
    })) << "the click was lost, or was taken for a drag";
    Do("key Return");
    ASSERT_TRUE(Comes([](const json& s) { return s["annotate.instances"] == 1; }));
    Do("key Escape");
    ASSERT_TRUE(Comes([](const json& s) { return s["annotate.tool"] == "select"; }));
  }
  void AClickAfterAJumpLandsWhereItIsAndTurnsNothing();
  void ATremblingHandClicksAndAQuickDragMovesAllTheWay();
  void NumbersTypedAndLeftByTabCountOnceEach();
  void ADoubleClickTurnsTheViewAboutThatPoint();
  json Eye() const { return State()["annotate"]["eye_in_level"]; }
  Eigen::Vector3d Place() const {
    const json pose = State()["annotate"]["instances"][0]["scan_from_object"];
    return Eigen::Vector3d(pose[0][3].get<double>(), pose[1][3].get<double>(),
                           pose[2][3].get<double>());
  }

  AnnotationScene scene_;
  json eye_;
};

void RealAnnotation::AClickAfterAJumpLandsWhereItIsAndTurnsNothing() {
  EXPECT_EQ(Eye(), eye_) << "the view has turned";
  EXPECT_LT((Place() - scene_.scan_from_armchair.translation()).norm(), 0.01);
  // On the object, off it, and on it again, each at once.
  for (const bool on : {false, true, false}) {
    Do(on ? MouseTo("annotate.view", 0.59, 0.43) + " click 1"
          : MouseTo("annotate.view", 0.05, 0.9) + " click 1");
    EXPECT_TRUE(Comes([&](const json& s) {
      return s["annotate.selected"] == (on ? "armchair_0" : "");
    })) << on;
  }
  EXPECT_EQ(Eye(), eye_);
}

void RealAnnotation::ATremblingHandClicksAndAQuickDragMovesAllTheWay() {
  const Eigen::Vector3d before = Place();
  const json eye = Eye();
  Do(MouseTo("annotate.view", 0.05, 0.9) +
     " mousedown 1 mousemove_relative 1 1 mousemove_relative 1 1 mouseup 1");
  EXPECT_TRUE(Comes([](const json& s) { return s["annotate.selected"] == ""; }));
  Do(MouseTo("annotate.view", 0.59, 0.43) + " mousedown 1 mousemove_relative 2 1 mouseup 1");
  EXPECT_TRUE(Comes([](const json& s) { return s["annotate.selected"] == "armchair_0"; }));
  Do(MouseTo("annotate.view", 0.59, 0.43) + " mousedown 1 mousemove_relative -- -2 1 mouseup 1");
  Rest();
  EXPECT_EQ(State()["annotate.undo"], "Add armchair_0") << "it was not moved";
  EXPECT_EQ(Eye(), eye);
  // A drag that is over before the next frame.
  Do(MouseTo("annotate.view", 0.59, 0.43) + " mousedown 1 mousemove_relative 60 0 mouseup 1");
  EXPECT_TRUE(Comes([](const json& s) { return s["annotate.undo"] == "Move armchair_0"; }));
  EXPECT_GT(Place().x(), before.x() + 0.1);
  EXPECT_EQ(Eye(), eye);
  Do(MouseTo("annotate.view", 0.05, 0.9) + " mousedown 1 mousemove_relative 80 0 mouseup 1");
  EXPECT_TRUE(Comes([&](const json& s) { return s["annotate"]["eye_in_level"] != eye; }))
      << "beside it, the same drag turns the view";
}

void RealAnnotation::NumbersTypedAndLeftByTabCountOnceEach() {
  const Eigen::Vector3d before = Place();
  Do(MouseTo("instance.x") + " click 1");
  Rest();
  Do("type --delay 1 1.25");
  Do("key --delay 1 Tab");
  Do("type --delay 1 -- -0.5");
  Do("key --delay 1 Tab");
  Do("key --delay 1 Tab");  // the height as it is
  EXPECT_TRUE(Comes([&](const json&) {
    return (Place() - Eigen::Vector3d(1.25, -0.5, 0)).norm() < 1e-6;
  })) << Place().transpose();
  Rest();
  Do("key Escape");
  Rest();
  Do("key ctrl+z");
  Do("key ctrl+z");
  EXPECT_TRUE(Comes([&](const json&) { return (Place() - before).norm() < 1e-9; }))
      << "two numbers are two edits";
}

void RealAnnotation::ADoubleClickTurnsTheViewAboutThatPoint() {
  Do("key Escape");  // a selected object under the mouse would keep the view
  EXPECT_TRUE(Comes([](const json& s) { return s["annotate.selected"] == ""; }));
  Do("key 5");
  Rest();
  const json eye = Eye();
  Do(MouseTo("annotate.view", 0.6, 0.4) + " click --repeat 2 --delay 60 1");
  EXPECT_TRUE(Comes([&](const json& s) { return s["annotate"]["eye_in_level"] != eye; }));
}

TEST_P(RealAnnotation, DoesWhatHandsMeanHoweverLongAFrameTakes) {
  PlaceArmchair();
  if (HasFatalFailure()) return;
  AClickAfterAJumpLandsWhereItIsAndTurnsNothing();
  Do(MouseTo("annotate.view", 0.59, 0.43) + " click 1");
  ATremblingHandClicksAndAQuickDragMovesAllTheWay();
  NumbersTypedAndLeftByTabCountOnceEach();
  ADoubleClickTurnsTheViewAboutThatPoint();
}

INSTANTIATE_TEST_SUITE_P(FrameMs, RealAnnotation, testing::Values(16, 200));

}  // namespace
}  // namespace plumbline
