// SPDX-License-Identifier: Apache-2.0
// The way from the X server through GLFW to the panels, with real events that xdotool sends. What
// each control does is tested by scripts in window_test.cc; here only that events arrive.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string>
#include <thread>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/platform/virtual_display.h"
#include "engine/base/files.h"
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
    window_ = fork();
    if (window_ == 0) {
      setenv("DISPLAY", display_->name().c_str(), 1);
      const std::string program = (ProgramFile().parent_path() / "fake_window").string();
      execl(program.c_str(), "fake_window", "--frames", "60", "--image", "240", "125", "--size",
            "1200", "800", "--state", state_file_.c_str(), static_cast<char*>(nullptr));
      _exit(127);
    }
  }
  void TearDown() override {
    if (window_ > 0) {
      kill(window_, SIGKILL);
      waitpid(window_, nullptr, 0);
    }
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

}  // namespace
}  // namespace plumbline
