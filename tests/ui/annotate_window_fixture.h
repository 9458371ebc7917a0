// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include <gmock/gmock.h>

#include "tests/support/annotation_walk.h"
#include "tests/ui/window_fixture.h"

namespace plumbline {

/// The real window's Annotate workspace on a private display and a small scan, driven by scripts.
class AnnotateWindow : public Window {
 protected:
  std::string Errors() const { return ReadFile(File("errors.txt")).value(); }

  /// Runs the steps once the scan can be aligned to, seen from above: the middle of the view is
  /// the origin of the floor, up in the picture is +y.
  /// @param before  What the shell does first, in the folder; its last command runs the window.
  int Run(const std::string& steps, const std::string& path = "scan.ply", bool wait = true,
          const std::string& options = "", const std::string& before = "") {
    const std::string first = wait ? R"({"wait_for": {"annotate.aligns": true, "annotate.models": 5,
        "annotate.busy": ""}}, {"key": "5"}, {"wait_frames": 3},)"
                                   : "";
    std::ofstream(File("script.json")) << "{\"steps\": [" << first << steps << "]}";
    const std::string program = (ProgramFile().parent_path() / "fake_window").string();
    const std::string command =
        "cd '" + folder_.path().string() + "' && export DISPLAY=" + display_->name() + " && " +
        before + " timeout 100 '" + program + "' --open " + path +
        " --size 1200 800 --script script.json " + options + " 2>errors.txt";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  /// What the state says of this workspace.
  nlohmann::json State(const std::string& name) const {
    return Window::State(name).value("annotate", nlohmann::json::object());
  }
  static Eigen::Isometry3d PoseOf(const nlohmann::json& instance) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        pose.matrix()(row, column) = instance["scan_from_object"][row][column];
      }
    }
    return pose;
  }

  // Where things are in the view from above (script: key 5).
  static constexpr const char* kPlaceArmchair = R"(
      {"click": "annotate_models.armchair"},
      {"wait_for": {"annotate.tool": "place"}},
      {"click": "annotate.view", "at": [0.59, 0.43]},
      {"wait_for": {"annotate.proposal": "placement", "annotate.running": false}},)";
  static constexpr const char* kFloor = R"(
      {"click": "floor.pick"},
      {"wait_for": {"annotate.tool": "floor"}},
      {"click": "annotate.view", "at": [0.5, 0.75]},
      {"wait_for": {"annotate.proposal": "floor"}},
      {"key": "enter"},
      {"wait_for": {"annotate.floor_known": true, "annotate.tool": "select"}},
      {"key": "5"},
      {"wait_frames": 3},)";

  AnnotationScene scene_ = MakeAnnotationScene(folder_.path());
};

}  // namespace plumbline
