// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "engine/snapshot/map_snapshot.h"
#include "tests/ui/panel_harness.h"
#include "ui/inspect/panel_table.h"

namespace plumbline {
namespace {

/// Gives the made-up room poses of a filter: the first frames wait, then it tracks.
void AddOwnPoses(PanelHarness& harness) {
  auto poses = std::make_shared<OwnPoses>();
  for (int i = 0; i < 60; ++i) {
    OwnPoseReport frame;
    frame.ready = i >= 10;
    if (!frame.ready) frame.waits_for = "waiting for rest";
    frame.measured = i % 2 == 0;
    frame.tracks = {{1, {100, 100}, i, TrackState::kInState, 0.5f},
                    {2, {200, 120}, 3, TrackState::kRejected, 4},
                    {3, {220, 90}, 0, TrackState::kFollowed, 0}};
    if (frame.ready) {
      frame.vio.phase = VioPhase::kTracking;
      frame.vio.step.nis = 40;
      frame.vio.step.nis_dof = frame.measured ? 50 : 0;
      frame.nis_gate = 67;
      frame.world_from_cam = Eigen::Isometry3d(Eigen::Translation3d(0.1 * i, 0, 1));
      frame.cam_covariance.setIdentity();
      frame.points_in_world = {{0, 0, 0}, {1, 1, 0}};
      frame.floor = FloorReport{-1.3, 0.02, 40};
    }
    poses->frames.push_back(frame);
  }
  poses->loops.epochs = 1;
  poses->loops.closures = {
      {.image = 30, .old_image = 12, .closed_image = 31, .inliers = 25, .epoch = 1}};
  auto view = std::make_shared<SequenceView>(*harness.context.sequence);
  view->own_poses = poses;
  view->given_world_from_cam.assign(60, Eigen::Isometry3d::Identity());
  harness.context.sequence = view;
}

TEST(InertialPanel, SaysThatPosesAreGivenWhereTheyAre) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("inertial");
  harness.ShowFrame(30);
  harness.Draw(*panel, 3);
  EXPECT_GT(harness.vertices, 0);
  EXPECT_EQ(harness.widgets.Find("inertial.plot.0"), nullptr);
}

TEST(InertialPanel, ShowsNumbersAndCurves) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("inertial");
  for (const int frame : {0, 5, 30, 31, 59}) {
    harness.ShowFrame(frame);
    AddOwnPoses(harness);
    harness.Draw(*panel, 3);
    EXPECT_GT(harness.vertices, 200) << frame;
  }
  panel->LoadState({{"over_time", true}});
  harness.Draw(*panel, 3);
  EXPECT_NE(harness.widgets.Find("inertial.plot.4"), nullptr) << "the distance from the reference";
  EXPECT_EQ(panel->SaveState().at("over_time"), true);
  EXPECT_TRUE(harness.sink.commands.empty());
}

TEST(ImagePanel, DrawsTheTracksOfOwnPoses) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("image");
  harness.ShowFrame(30);
  harness.Draw(*panel, 3);
  const int without = harness.vertices;
  AddOwnPoses(harness);
  harness.Draw(*panel, 3);
  EXPECT_GT(harness.vertices, without + 30) << "three points of ten corners each";
  panel->LoadState({{"tracks", false}});
  harness.Draw(*panel, 3);
  EXPECT_LT(harness.vertices, without + 30);
}

TEST(ScenePanel, DrawsPointsAndTheSpreadOfTheCamera) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.ShowFrame(30);
  AddOwnPoses(harness);
  panel->LoadState({{"spread", true}, {"points", true}});
  harness.Draw(*panel, 3);
  EXPECT_GT(harness.vertices, 0);
}

TEST(ScenePanel, PointsOfMappedObjectsAreLeftOut) {
  PanelHarness harness;
  const auto panel = MakeInspectPanel("scene");
  harness.ShowFrame(59);
  AddOwnPoses(harness);
  panel->LoadState({{"points", true}});
  harness.Draw(*panel, 3);
  const int with_models = harness.vertices;
  auto view = std::make_shared<SequenceView>(*harness.context.sequence);
  for (ModelView& model : view->models) model.bounds.setEmpty();
  harness.context.sequence = view;
  harness.Draw(*panel, 3);
  EXPECT_GT(harness.vertices, with_models + 100) << "the points in the table";
}

}  // namespace
}  // namespace plumbline
