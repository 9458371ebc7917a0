// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/platform/virtual_display.h"
#include "engine/base/files.h"
#include "tests/support/test_data.h"

namespace plumbline {

/// The real window on made-up frames (fake_window), on a private display.
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

  nlohmann::json State(const std::string& name) const {
    const auto state = ReadJson(File(name));
    EXPECT_TRUE(state.ok()) << ReadFile(File("errors.txt")).value();
    return state.ok() ? *state : nlohmann::json::object();
  }

  TemporaryFolder folder_;
  static inline std::unique_ptr<VirtualDisplay> display_;
};

}  // namespace plumbline
