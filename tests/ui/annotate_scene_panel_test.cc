// SPDX-License-Identifier: Apache-2.0
// The 3-D view of the Annotate workspace and its handles without a display.

#include "ui/annotate/annotate_panels.h"
#include "ui/annotate/annotate_view_menu.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ui/annotate_harness.h"
#include "ui/annotate/annotate_edits.h"

namespace plumbline {
namespace {

TEST(AnnotateScenePanel, AClickDoesWhatTheToolSays) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.surface.under_mouse = "table_0";
  harness.Click(*panel, "annotate.view");
  ASSERT_NE(harness.sink.Last<SelectInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "table_0");
  harness.Click(*panel, "annotate.tool.floor");
  EXPECT_EQ(harness.view.tool, AnnotateTool::kFloor);
  harness.Click(*panel, "annotate.view", 0.25f, 0.5f);
  ASSERT_NE(harness.sink.Last<FindFloorCommand>(), nullptr);
  const auto& rect = *harness.widgets.Find("annotate.view");
  const Eigen::Vector3d seed = harness.sink.Last<FindFloorCommand>()->seed_in_scan.value();
  EXPECT_NEAR(seed.x(), 0.25 * (rect.high.x - rect.low.x) / 100, 0.02);
  harness.view.tool = AnnotateTool::kPlace;
  harness.view.model = "table";
  harness.view.on_floor = false;
  harness.Click(*panel, "annotate.view", 0.6f, 0.5f);
  ASSERT_NE(harness.sink.Last<PlaceModelCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<PlaceModelCommand>()->model, "table");
  EXPECT_FALSE(harness.sink.Last<PlaceModelCommand>()->on_floor);
}

TEST(AnnotateScenePanel, AClickCountsWhereTheButtonWentDownHoweverTheHandTrembles) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.view.tool = AnnotateTool::kFloor;
  harness.JumpAndClick(*panel, "annotate.view", {0.7f, 0.4f}, {2, -3});
  ASSERT_NE(harness.sink.Last<FindFloorCommand>(), nullptr);
  const auto& rect = *harness.widgets.Find("annotate.view");
  const Eigen::Vector3d seed = harness.sink.Last<FindFloorCommand>()->seed_in_scan.value();
  EXPECT_NEAR(seed.x(), 0.7 * (rect.high.x - rect.low.x) / 100, 0.012);
  EXPECT_NEAR(seed.y(), -0.4 * (rect.high.y - rect.low.y) / 100, 0.012);
  EXPECT_EQ(harness.surface.orbited, 0);
  harness.sink.commands.clear();
  harness.JumpAndClick(*panel, "annotate.view", {0.7f, 0.4f}, {0, 5});
  EXPECT_EQ(harness.sink.Last<FindFloorCommand>(), nullptr) << "a drag";
}

TEST(AnnotateScenePanel, ARightClickOffersWhatCanBeDoneWithTheObjectUnderTheMouse) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.surface.under_mouse = "table_0";
  harness.JumpAndClick(*panel, "annotate.view", {0.5f, 0.5f}, {1, 1}, 1);
  ASSERT_NE(harness.sink.Last<SelectInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "table_0");
  harness.snapshot().selected = "table_0";
  harness.Draw(*panel, 2);
  EXPECT_EQ(harness.widgets.Find("menu.Hide the scan"), nullptr) << "it is about the object";
  harness.Click(*panel, "menu.Delete it");
  ASSERT_NE(harness.sink.Last<RemoveInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<RemoveInstanceCommand>()->id, "table_0");
  harness.Draw(*panel, 2);
  EXPECT_EQ(harness.widgets.Find("menu.Delete it"), nullptr) << "the menu is gone";
  harness.surface.under_mouse.clear();
  harness.snapshot().selected.clear();
  harness.JumpAndClick(*panel, "annotate.view", {0.5f, 0.5f}, {0, 0}, 1);
  harness.Draw(*panel, 2);
  EXPECT_NE(harness.widgets.Find("menu.Show the scan"), nullptr);
}

TEST(AnnotateScenePanel, ShiftAndCtrlClickSelectOneMoreOrOneLess) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.surface.under_mouse = "table_0";
  ImGui::GetIO().KeyShift = true;
  harness.Click(*panel, "annotate.view");
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>(), nullptr) << "the armchair stays";
  EXPECT_EQ(harness.view.also_selected, std::vector<std::string>{"table_0"});
  harness.Draw(*panel);
  EXPECT_EQ(harness.surface.content.also_selected, std::vector<std::string>{"table_0"})
      << "it is marked";
  ImGui::GetIO().KeyShift = false;
  // A right click on one of them is about all of them.
  harness.JumpAndClick(*panel, "annotate.view", {0.5f, 0.5f}, {1, 1}, 1);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>(), nullptr);
  harness.Draw(*panel, 2);
  harness.Click(*panel, "menu.Hide it");
  ASSERT_NE(harness.sink.Last<ChangeInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->and_also,
            std::vector<std::string>{"table_0"});
}

TEST(AnnotateScenePanel, CtrlClickOnTheSelectedObjectLeavesTheOthersSelected) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.view.also_selected = {"table_0"};
  harness.surface.under_mouse = "armchair_0";
  ImGui::GetIO().KeyCtrl = true;
  harness.Click(*panel, "annotate.view");
  ImGui::GetIO().KeyCtrl = false;
  ASSERT_NE(harness.sink.Last<SelectInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "table_0");
  EXPECT_TRUE(harness.view.also_selected.empty());
}

TEST(AnnotateScenePanel, BSelectsWhatABoxEncloses) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.snapshot().selected.clear();
  harness.Draw(*panel);
  harness.Press(keys::kB);
  ASSERT_TRUE(harness.view.boxing);
  // The armchair is at (1, -1) m, the table at (3, -2), 100 pixels each.
  const AnnotationSnapshot before = harness.snapshot();
  harness.Drag(*panel, "annotate.view", {0.02f, 0.02f}, {0.9f, 0.9f}, 0);
  EXPECT_EQ(harness.surface.orbited, 0) << "the view stays";
  EXPECT_FALSE(harness.view.boxing) << "one drag";
  ASSERT_NE(harness.sink.Last<SelectInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "armchair_0");
  harness.snapshot().selected = "armchair_0";
  FollowSnapshot(before, harness.snapshot(), harness.view);
  EXPECT_EQ(harness.view.also_selected, std::vector<std::string>{"table_0"});
  harness.Press(keys::kB);
  harness.Press(keys::kEscape);
  EXPECT_FALSE(harness.view.boxing);
}

TEST(AnnotateScenePanel, AModelGoesOntoTheFloorWhereTheScanHasAHole) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.surface.empty = true;
  harness.view.tool = AnnotateTool::kPlace;
  harness.view.model = "table";
  harness.snapshot().floor_known = false;
  harness.Click(*panel, "annotate.view", 0.6f, 0.5f);
  EXPECT_EQ(harness.sink.Last<PlaceModelCommand>(), nullptr);
  harness.snapshot().floor_known = true;
  harness.Click(*panel, "annotate.view", 0.6f, 0.5f);
  ASSERT_NE(harness.sink.Last<PlaceModelCommand>(), nullptr);
  EXPECT_NEAR(harness.sink.Last<PlaceModelCommand>()->point_in_scan.z(), 0, 1e-12);
}

/// The armchair at 100 pixels a metre, under the mouse everywhere.
class GizmoTest : public testing::Test {
 protected:
  GizmoTest() {
    harness_.size = {900, 500};
    harness_.surface.under_mouse = "armchair_0";
  }
  void Drag(float from, float to) {
    harness_.Drag(*panel_, "annotate.view", {from, 0.9f}, {to, 0.9f}, 0);
  }
  AnnotateHarness harness_;
  std::unique_ptr<Panel> panel_ = MakeAnnotatePanel("annotate_scene");
};

TEST_F(GizmoTest, DraggingMovesAlongTheFloorAndIsOneEditAtTheEnd) {
  Drag(0.5f, 0.6f);
  const auto* moved = harness_.sink.Last<SetInstancePoseCommand>();
  ASSERT_NE(moved, nullptr);
  EXPECT_EQ(moved->id, "armchair_0");
  const auto& rect = *harness_.widgets.Find("annotate.view");
  EXPECT_NEAR(moved->scan_from_object.translation().x(), 1 + 0.1 * (rect.high.x - rect.low.x) / 100,
              0.02);
  EXPECT_EQ(moved->scan_from_object.translation().z(), 0);
  ASSERT_TRUE(harness_.view.pending.has_value()) << "shown until the project has it";
  EXPECT_EQ(harness_.surface.orbited, 0) << "the view stays";
}

TEST_F(GizmoTest, AClickOnAPoseThatIsOnItsWayIsNoEdit) {
  Drag(0.5f, 0.6f);
  const Eigen::Isometry3d pose = harness_.view.pending->scan_from_object;
  const std::size_t commands = harness_.sink.commands.size();
  harness_.Click(*panel_, "annotate.view", 0.6f, 0.9f);
  EXPECT_EQ(harness_.sink.commands.size(), commands);
  EXPECT_EQ(harness_.view.pending->scan_from_object.matrix(), pose.matrix());
  Drag(0.6f, 0.7f);
  EXPECT_GT(harness_.sink.Last<SetInstancePoseCommand>()->scan_from_object.translation().x(),
            pose.translation().x() + 0.5)
      << "goes on from where it is shown";
}

TEST_F(GizmoTest, ATremblingClickMovesNothing) {
  harness_.JumpAndClick(*panel_, "annotate.view", {0.5f, 0.9f}, {3, 1});
  EXPECT_EQ(harness_.sink.Last<SetInstancePoseCommand>(), nullptr);
  EXPECT_FALSE(harness_.view.pending.has_value());
  harness_.JumpAndClick(*panel_, "annotate.view", {0.5f, 0.9f}, {5, 0});
  ASSERT_NE(harness_.sink.Last<SetInstancePoseCommand>(), nullptr);
  EXPECT_NEAR(harness_.sink.Last<SetInstancePoseCommand>()->scan_from_object.translation().x(),
              1.05, 1e-6)
      << "a drag counts from where it began";
}

TEST_F(GizmoTest, WhatIsLockedStays) {
  harness_.snapshot().instances[0].locked = true;
  Drag(0.5f, 0.6f);
  EXPECT_EQ(harness_.sink.Last<SetInstancePoseCommand>(), nullptr);
  EXPECT_NE(harness_.surface.orbited, 0);
}

TEST(AnnotateScenePanel, ABoxComesToStandWhereItIsClickedAndIsCounted) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.view.tool = AnnotateTool::kCut;
  harness.Click(*panel, "annotate.view");
  ASSERT_TRUE(harness.view.crop_box.has_value());
  harness.Draw(*panel);
  ASSERT_NE(harness.sink.Last<ShowBoxCommand>(), nullptr);
  EXPECT_TRUE(harness.sink.Last<ShowBoxCommand>()->box.has_value());
  harness.Click(*panel, "annotate.tool.select");
  harness.Draw(*panel);
  EXPECT_FALSE(harness.sink.Last<ShowBoxCommand>()->box.has_value()) << "gone with the tool";
}

TEST(AnnotateScenePanel, TheBoxThatFitsTakesThePlaceOfTheUsualOne) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.view.tool = AnnotateTool::kCut;
  harness.Click(*panel, "annotate.view");
  const auto* asked = harness.sink.Last<FitBoxCommand>();
  ASSERT_NE(asked, nullptr);
  ASSERT_TRUE(harness.view.crop_box.has_value());
  const Eigen::Vector3d clicked = harness.view.crop_box->center;
  EXPECT_NEAR((harness.snapshot().level_from_scan * asked->point_in_scan).x(), clicked.x(), 1e-9);
  const AnnotationSnapshot before = harness.snapshot();
  UprightBox box{harness.snapshot().level_from_scan.inverse() * Eigen::Vector3d(1, 2, 0.5),
                 {0.3, 0.4, 1},
                 0.7};
  harness.snapshot().fitted_box = std::make_shared<const FittedBoxView>(FittedBoxView{box});
  FollowSnapshot(before, harness.snapshot(), harness.view);
  ASSERT_TRUE(harness.view.crop_box.has_value());
  EXPECT_LT((harness.view.crop_box->center - Eigen::Vector3d(1, 2, 0.5)).norm(), 1e-9);
  EXPECT_EQ(harness.view.crop_box->size_m, Eigen::Vector3d(0.3, 0.4, 1));
  // Where none fits, and to what was changed by hand since, nothing happens.
  const AnnotationSnapshot then = harness.snapshot();
  harness.snapshot().fitted_box = std::make_shared<const FittedBoxView>();
  FollowSnapshot(then, harness.snapshot(), harness.view);
  EXPECT_EQ(harness.view.crop_box->size_m, Eigen::Vector3d(0.3, 0.4, 1));
}

TEST(AnnotateViewMenu, ChoosesWhatTheColoursOfTheScanMean) {
  AnnotateHarness harness;
  harness.size = {1100, 500};
  const auto panel = MakeAnnotatePanel("annotate_scene");
  auto scan = std::make_shared<TriangleMesh>();
  scan->vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  harness.snapshot().scan = scan;
  harness.Click(*panel, "annotate.looks");
  harness.Draw(*panel, 2);
  ASSERT_NE(harness.widgets.Find("looks.points"), nullptr) << "a cloud has points";
  harness.Click(*panel, "looks.own");
  EXPECT_FALSE(harness.surface.content.scan_look.coloring) << "it has none";
  harness.Click(*panel, "looks.height");
  EXPECT_EQ(harness.surface.content.scan_look.coloring, ScanColoring::kHeight);
  auto mesh = std::make_shared<TriangleMesh>(*scan);
  mesh->triangles = {{0, 1, 2}};
  harness.snapshot().scan = mesh;
  harness.Click(*panel, "looks.normal");
  EXPECT_EQ(harness.surface.content.scan_look.coloring, ScanColoring::kNormal);
  EXPECT_EQ(harness.widgets.Find("looks.points"), nullptr) << "a mesh has none";
}

TEST(AnnotateViewMenu, KeepsViewsGoesThereAndForgetsThem) {
  AnnotateHarness harness;
  harness.size = {1100, 500};
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.surface.view.distance_m = 4;
  harness.Click(*panel, "annotate.looks");
  harness.Click(*panel, "looks.keep");
  ASSERT_EQ(harness.view.saved_views.size(), 1u);
  EXPECT_EQ(harness.view.saved_views[0].name, "View 1");
  harness.surface.view.distance_m = 7;
  harness.view.view_name = "from the door";
  harness.Click(*panel, "looks.keep");
  ASSERT_EQ(harness.view.saved_views.size(), 2u);
  EXPECT_EQ(harness.view.saved_views[1].name, "from the door");
  EXPECT_EQ(SavedViewsFromJson(ToJson(harness.view.saved_views))[1].camera.distance_m, 7);
  harness.Click(*panel, "looks.view.0");
  EXPECT_EQ(harness.surface.view.distance_m, 4);
  std::vector<PaletteEntry> entries;
  AddViewEntries(harness.context, entries);
  const auto door = std::find_if(entries.begin(), entries.end(), [](const PaletteEntry& entry) {
    return entry.text == "View: from the door";
  });
  ASSERT_NE(door, entries.end());
  door->run(harness.sink);
  EXPECT_EQ(harness.surface.view.distance_m, 7);
  harness.Click(*panel, "annotate.looks");
  harness.Click(*panel, "looks.forget.1");
  EXPECT_EQ(harness.view.saved_views.size(), 1u);
}

TEST(AnnotateViewMenu, LeavesOutWhatSettingsDoNotSayProperly) {
  EXPECT_TRUE(SavedViewsFromJson({{{"name", "no place"}}, 3, {{"focus", {1, 2, 3}}}}).empty());
  EXPECT_EQ(ScanLookFromJson({{"point_px", 900}, {"coloring", "smell"}}),
            (ScanLook{std::nullopt, 8}));
}

TEST(AnnotateMasksPanel, AsksAgainOnceSomethingHasMovedAndSelectsWhatIsClicked) {
  AnnotateHarness harness;
  harness.size = {640, 420};
  const auto panel = MakeAnnotatePanel("annotate_masks");
  harness.Draw(*panel, 3);
  ASSERT_NE(harness.sink.Last<ShowFrameCommand>(), nullptr);
  EXPECT_EQ(harness.sink.commands.size(), 1u) << "once";
  EXPECT_TRUE(harness.sink.Last<ShowFrameCommand>()->masks);
  FrameView frame{3, cv::Mat(90, 160, CV_8UC3, cv::Scalar(60, 60, 60)), ""};
  harness.snapshot().frame = frame;  // as the other panel reads it
  harness.sink.commands.clear();
  harness.Draw(*panel, 3);
  ASSERT_EQ(harness.sink.commands.size(), 1u) << "once";
  frame.masks = true;
  frame.instances = cv::Mat::zeros(90, 160, CV_16U);
  frame.instances.colRange(0, 80).setTo(1);
  harness.snapshot().frame = frame;
  harness.snapshot().frame_size = {160, 90};
  harness.Draw(*panel, 3);
  harness.sink.commands.clear();
  harness.Draw(*panel, 3);
  EXPECT_TRUE(harness.sink.commands.empty());
  harness.snapshot().instances[0].scan_from_object.translation().x() += 0.1;
  harness.Draw(*panel, 3);
  ASSERT_NE(harness.sink.Last<ShowFrameCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ShowFrameCommand>()->frame, 3);
  EXPECT_EQ(harness.sink.commands.size(), 1u);
  harness.Click(*panel, "masks.view", 0.2f);
  ASSERT_NE(harness.sink.Last<SelectInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, harness.snapshot().instances[0].id);
  harness.Click(*panel, "masks.view", 0.8f);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "") << "nothing is there";
  harness.view.masks = true;
  harness.Click(*panel, "masks.close");
  EXPECT_FALSE(harness.view.masks);
}

TEST_F(GizmoTest, OnlyWhatMayTiltHasRingsThatTiltIt) {
  harness_.Draw(*panel_, 2);
  const auto& rect = *harness_.widgets.Find("annotate.view");
  const AnnotatedInstance& chair = harness_.snapshot().instances[0];
  const Eigen::Vector3d foot =
      (harness_.snapshot().level_from_scan * chair.scan_from_object).translation();
  // Seen from above, the ring about x is a line through the foot along y.
  const auto x = static_cast<float>(100 * foot.x()) / (rect.high.x - rect.low.x);
  const auto y = static_cast<float>(20 - 100 * foot.y()) / (rect.high.y - rect.low.y);
  const auto tilt_rad = [&] {
    harness_.Drag(*panel_, "annotate.view", {x, y}, {x + 0.05f, y}, 0);
    const auto* moved = harness_.sink.Last<SetInstancePoseCommand>();
    return moved == nullptr ? -1 : std::acos(std::min(1.0, moved->scan_from_object.linear()(2, 2)));
  };
  EXPECT_NEAR(tilt_rad(), 0, 1e-6) << "moved along the floor";
  harness_.view.pending.reset();
  harness_.snapshot().instances[0].may_tilt = true;
  EXPECT_GT(tilt_rad(), 0.1);
}

}  // namespace
}  // namespace plumbline
