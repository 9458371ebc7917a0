// SPDX-License-Identifier: Apache-2.0
// Panels of the Annotate workspace without a display: what they say, what they post, and that no
// state of a project upsets them.

#include "ui/annotate/annotate_panels.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ui/annotate_harness.h"

namespace plumbline {
namespace {

using testing::HasSubstr;
using testing::Not;

std::vector<std::unique_ptr<Panel>> AllPanels() {
  std::vector<std::unique_ptr<Panel>> panels;
  for (const AnnotatePanelEntry& entry : AnnotatePanels())
    panels.push_back(MakeAnnotatePanel(entry.info.id));
  return panels;
}

RefinementView MadeUpRefinement() {
  RefinementView refinement;
  refinement.instance = "armchair_0";
  refinement.running = false;
  refinement.converged = true;
  refinement.iteration = 12;
  refinement.fitness = 0.8;
  refinement.has_scan = true;
  refinement.before.fitness = 0.5;
  refinement.azimuth_rad = 0.1;
  refinement.azimuth_std_rad = 0.01;
  refinement.horizontal_m = 0.02;
  refinement.rmse_m = 0.003;
  refinement.before.rmse_m = 0.009;
  return refinement;
}

FloorProposal MadeUpFloor() {
  FloorProposal floor;
  floor.source = "picked";
  floor.offset_m = -0.25;
  floor.inliers = floor.outliers = std::make_shared<const std::vector<Eigen::Vector3f>>();
  floor.num_inliers = 4321;
  floor.turn_rad = 0.02;
  return floor;
}

ImageChecksView MadeUpChecks() {
  ImageChecksView checks;
  checks.instance = "armchair_0";
  checks.running = false;
  checks.agreement = 0.42;
  for (int i = 0; i < 2; ++i) {
    ImageCheckView check;
    check.frame = 10 * (i + 1);
    check.image = cv::Mat(90, 160, CV_8UC3, cv::Scalar(60, 60, 60));
    check.scan_from_cam.translation() = Eigen::Vector3d(i, 2, 3);
    check.lines = {{false, false, {{10, 10}, {60, 60}}}, {true, true, {{20, 10}, {60, 20}}}};
    check.agreement = 0.4;
    checks.images.push_back(check);
  }
  return checks;
}

SequenceAlignmentView MadeUpAlignment() {
  SequenceAlignmentView alignment;
  alignment.how = "objects";
  alignment.running = false;
  alignment.turn_rad = 0.5;
  alignment.shift_m = 0.123;
  alignment.rmse_m = 0.02;
  alignment.residuals = {{"table 2", 0.015}, {"chair 4", -1}};
  return alignment;
}

CropView MadeUpCrop() {
  CropView crop{"stool"};
  crop.running = false;
  crop.size_m = {0.4, 0.5, 0.6};
  crop.num_faces = 900;
  crop.points = std::make_shared<const std::vector<Eigen::Vector3f>>(7);
  return crop;
}

void FillEverything(AnnotationSnapshot& snapshot) {
  snapshot.floor = MadeUpFloor();
  snapshot.placement = MadeUpPlacement();
  snapshot.refinement = MadeUpRefinement();
  snapshot.sequence_alignment = MadeUpAlignment();
  snapshot.crop = MadeUpCrop();
  snapshot.checks = MadeUpChecks();
  snapshot.frame = FrameView{3, cv::Mat(90, 160, CV_8UC3, cv::Scalar(60, 60, 60)), ""};
  snapshot.pairs = {{{1, -1, 0}, 3, {40, 50}, Eigen::Vector2d(44, 53), 5},
                    {{2, -1, 0}, 7, {40, 50}, std::nullopt, 0}};
  snapshot.notices = {"3 edits recovered"};
  snapshot.num_recovered = 3;
  snapshot.journal_problem = "no room";
}

/// The bar over the workspace, as if it were a panel.
class ProjectBar : public Panel {
 public:
  ProjectBar() {
    PanelInfo info;
    info.id = "project_bar";
    set_info(info);
  }
  void Draw(const FrameContext& context, CommandSink& sink) override {
    const ImVec2 low = ImGui::GetCursorScreenPos();
    DrawProjectBar(context, {low, {low.x + 1060, low.y + 40}}, sink);
  }
};

TEST(AnnotatePanels, DrawInEveryStateOfAProject) {
  const std::vector<std::function<void(AnnotationSnapshot&)>> states = {
      [](AnnotationSnapshot& s) { s = AnnotationSnapshot(); },
      [](AnnotationSnapshot&) {},
      [](AnnotationSnapshot& s) { s.selected.clear(); },
      [](AnnotationSnapshot& s) { s.selected = "nobody"; },
      [](AnnotationSnapshot& s) { s.models = AnnotationSnapshot().models; },
      [](AnnotationSnapshot& s) { s.read_only = true; },
      [](AnnotationSnapshot& s) {
        s.placement = PlacementView();
        s.refinement = RefinementView();
        s.sequence_alignment = SequenceAlignmentView();
        s.crop = CropView();
        s.checks = ImageChecksView();
        s.frame = FrameView();
      },
      FillEverything};
  for (std::size_t i = 0; i < states.size(); ++i) {
    for (const auto& panel : AllPanels()) {
      SCOPED_TRACE(std::string(panel->id()) + " in state " + std::to_string(i));
      AnnotateHarness harness;
      states[i](harness.snapshot());
      harness.Draw(*panel, 3);
      EXPECT_GT(harness.vertices, 0);
      const bool asks = std::string(panel->id()) == "annotate_frame";  // for its first frame
      EXPECT_TRUE(asks || harness.sink.commands.empty()) << "nobody asked for anything";
      for (const ImVec2 size : {ImVec2(12, 12), ImVec2(90, 700), ImVec2(900, 60)}) {
        harness.size = size;
        harness.Draw(*panel, 2);
      }
    }
  }
}

/// The sheet, as if it were a panel.
class QueueSheet : public Panel {
 public:
  QueueSheet() {
    PanelInfo info;
    info.id = "queue_sheet";
    set_info(info);
  }
  void Draw(const FrameContext& context, CommandSink& sink) override { DrawQueue(context, sink); }
};

TEST(AnnotateQueue, HandsOverAndLetsSomebodyElseJudge) {
  AnnotateHarness harness;
  QueueSheet sheet;
  harness.size = {720, 480};
  harness.snapshot().annotator = "Ada";
  harness.snapshot().stage = WorkStage::kInWork;
  harness.Type(sheet, "queue.note", "mind the lamp");
  harness.Click(sheet, "queue.hand_over");
  ASSERT_NE(harness.sink.Last<SetStageCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SetStageCommand>()->stage, WorkStage::kToReview);
  EXPECT_EQ(harness.sink.Last<SetStageCommand>()->note, "mind the lamp");
  harness.snapshot().stage = WorkStage::kToReview;
  harness.snapshot().project_state = ProjectState{WorkStage::kToReview, "Ada", "", "mind the lamp"};
  const std::string own = harness.Text(sheet);
  EXPECT_THAT(own, HasSubstr("handed over by Ada"));
  EXPECT_THAT(own, HasSubstr("somebody else reviews it"));
  EXPECT_EQ(harness.widgets.Find("queue.done"), nullptr);
  harness.snapshot().annotator = "Grace";
  harness.Click(sheet, "queue.done");
  EXPECT_EQ(harness.sink.Last<SetStageCommand>()->stage, WorkStage::kDone);
  harness.Click(sheet, "queue.back");
  EXPECT_EQ(harness.sink.Last<SetStageCommand>()->stage, WorkStage::kInWork);
}

TEST(AnnotateQueue, ListsTheFolderAndOpensWhatIsClicked) {
  AnnotateHarness harness;
  QueueSheet sheet;
  harness.size = {720, 480};
  AnnotationQueueView queue;
  queue.folder = "/scans";
  queue.entries = {{"a.ply", "/scans/a.ply"},
                   {"b.json", "/scans/b.json", WorkStage::kDone, {"Ada"}, "Grace", "", 7, 840, ""},
                   {"c.json", "/scans/c.json", WorkStage::kNew, {}, "", "", 0, 0, "is damaged"}};
  queue.open = 1;
  harness.snapshot().queue = queue;
  const std::string text = harness.Text(sheet);
  EXPECT_THAT(text, HasSubstr("Ada; reviewed by Grace"));
  EXPECT_THAT(text, HasSubstr("14 min"));
  EXPECT_THAT(text, HasSubstr("cannot be read"));
  EXPECT_THAT(text, HasSubstr("2 new, 1 done; 7 objects in 14 min"));
  harness.Click(sheet, "queue.row.b.json", 0.1f);
  EXPECT_EQ(harness.sink.Last<OpenCommand>(), nullptr) << "it is open";
  harness.Click(sheet, "queue.row.a.ply", 0.1f);
  ASSERT_NE(harness.sink.Last<OpenCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<OpenCommand>()->path, "/scans/a.ply");
  harness.Type(sheet, "queue.folder", "/more");
  EXPECT_EQ(harness.sink.Last<ListQueueCommand>()->folder, "/more");
}

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

TEST(AnnotateExport, AsksBeforeItReplacesAndPassesTheAnswerOn) {
  AnnotateHarness harness;
  harness.size = {1100, 640};
  ProjectBar bar;
  harness.snapshot().project_file = "made_up.json";
  ExportView exported{false, "", "2 objects written"};
  exported.asks = true;
  exported.out = "/data/ground_truth.json";
  exported.differences = {"1 object would be gone: chair_3."};
  harness.snapshot().exported = exported;
  harness.Click(bar, "project.export");
  harness.Click(bar, "export.write");
  EXPECT_TRUE(harness.sink.commands.empty()) << "not while it asks";
  harness.Click(bar, "export.leave");
  ASSERT_NE(harness.sink.Last<AnswerExportCommand>(), nullptr);
  EXPECT_FALSE(harness.sink.Last<AnswerExportCommand>()->replace);
  harness.Click(bar, "export.replace");
  EXPECT_TRUE(harness.sink.Last<AnswerExportCommand>()->replace);
}

TEST(AnnotateProjectBar, ButtonsStayWhereTheyAreWhateverTheySay) {
  AnnotateHarness harness;
  harness.size = {1100, 420};
  ProjectBar bar;
  harness.snapshot().project_file = "made_up.json";
  harness.Draw(bar, 2);
  const float before = harness.widgets.Find("project.export")->low.x;
  harness.snapshot().undo_label = "Move a_chair_with_a_very_long_name_indeed_0";
  harness.snapshot().redo_label = "Add";
  harness.snapshot().modified = true;
  harness.Draw(bar, 2);
  EXPECT_EQ(harness.widgets.Find("project.export")->low.x, before);
  harness.snapshot().journal_problem = "no room";
  harness.Draw(bar, 2);
  EXPECT_EQ(harness.widgets.Find("project.export")->low.x, before);
}

TEST(AnnotateBanners, AskForTheUnitOfAScanThatIsTooLarge) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_scene");
  harness.size = {900, 500};
  harness.snapshot().instances.clear();
  harness.snapshot().doubted_size_m = 5230;
  harness.Draw(*panel, 2);
  harness.Click(*panel, "annotate.unit.mm");
  ASSERT_NE(harness.sink.Last<SetScanUnitCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<SetScanUnitCommand>()->metres_per_unit, 0.001);
  harness.Click(*panel, "annotate.unit.m");
  EXPECT_EQ(harness.sink.Last<SetScanUnitCommand>()->metres_per_unit, 1);
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

TEST(AnnotateModelsPanel, AClickChoosesWhatIsPlacedNextAndASecondOneDoesNot) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_models");
  harness.Click(*panel, "annotate_models.table");
  EXPECT_EQ(harness.view.tool, AnnotateTool::kPlace);
  EXPECT_EQ(harness.view.model, "table");
  EXPECT_NE(harness.sink.Last<CancelProposalCommand>(), nullptr);
  harness.Click(*panel, "annotate_models.table");
  EXPECT_EQ(harness.view.tool, AnnotateTool::kSelect);
  EXPECT_GT(harness.textures.pictures_made, 1);
}

TEST(AnnotateModelsPanel, TheFilterKeepsWhatFits) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_models");
  harness.Type(*panel, "annotate_models.filter", "DINING");
  EXPECT_EQ(harness.widgets.Find("annotate_models.armchair"), nullptr);
  EXPECT_NE(harness.widgets.Find("annotate_models.table"), nullptr) << "by its category";
  harness.snapshot().models = AnnotationSnapshot().models;
  harness.snapshot().models_problem = "The folder is empty.";
  EXPECT_EQ(harness.widgets.Find("annotate_models.none"), nullptr);
  harness.Draw(*panel);
  EXPECT_EQ(harness.widgets.Find("annotate_models.table"), nullptr);
}

TEST(AnnotateInstancesPanel, SelectsHidesLocksAndGradesARow) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instances");
  EXPECT_THAT(harness.Text(*panel), HasSubstr("2 objects"));
  harness.Click(*panel, "annotate_instances.row.table_0", 0.2f);
  EXPECT_EQ(harness.sink.Last<SelectInstanceCommand>()->id, "table_0");
  harness.Click(*panel, "annotate_instances.hide.table_0");
  const auto* change = harness.sink.Last<ChangeInstanceCommand>();
  ASSERT_NE(change, nullptr);
  EXPECT_EQ(change->id, "table_0");
  EXPECT_EQ(change->set.hidden, true);
  EXPECT_FALSE(change->set.locked || change->set.fine);
  harness.snapshot().instances[1].locked = true;
  harness.Click(*panel, "annotate_instances.lock.table_0");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.locked, false);
  harness.Click(*panel, "annotate_instances.quality.table_0");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.fine, false);
}

TEST(AnnotateImagesPanel, SaysHowMuchLiesOnEdgesAndLooksFromThere) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_images");
  harness.size = {700, 200};
  harness.snapshot().checks = MadeUpChecks();
  harness.snapshot().images_number = 1;
  EXPECT_THAT(harness.Text(*panel), HasSubstr("42 % of the outline on edges"));
  EXPECT_EQ(harness.textures.pictures_made, 2);
  harness.Click(*panel, "images.1");
  ASSERT_TRUE(harness.view.look_from.has_value());
  EXPECT_EQ(*harness.view.look_from, Eigen::Vector3d(1, 2, 3));
  EXPECT_TRUE(harness.sink.commands.empty());
}

TEST(AnnotateFloorPanel, FindsPicksAndTypes) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_floor");
  harness.snapshot().floor_known = false;
  EXPECT_THAT(harness.Text(*panel), HasSubstr("where is it?"));
  harness.Click(*panel, "floor.find");
  ASSERT_NE(harness.sink.Last<FindFloorCommand>(), nullptr);
  EXPECT_FALSE(harness.sink.Last<FindFloorCommand>()->seed_in_scan.has_value());
  harness.Click(*panel, "floor.pick");
  EXPECT_EQ(harness.view.tool, AnnotateTool::kFloor);
  harness.Click(*panel, "floor.typed", 0.1f);
  harness.Type(*panel, "floor.height", "0.5");
  harness.Click(*panel, "floor.type");
  const auto* typed = harness.sink.Last<TypeGravityCommand>();
  ASSERT_NE(typed, nullptr);
  EXPECT_EQ(typed->up_in_scan, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(typed->floor_offset_m, -0.5) << "up . x + offset = 0 at that height";
  harness.snapshot().ready_to_align = false;
  harness.sink.commands.clear();
  harness.Click(*panel, "floor.find");
  EXPECT_TRUE(harness.sink.commands.empty()) << "not before the scan is prepared";
}

TEST(AnnotateProjectBar, ExportsFragmentsWithoutObjectsButNotNothing) {
  AnnotateHarness harness;
  harness.size = {1100, 420};
  ProjectBar bar;
  harness.snapshot().project_file = "made_up.json";
  harness.snapshot().instances.clear();
  harness.Click(bar, "project.export");
  EXPECT_EQ(harness.widgets.Find("export.write"), nullptr);
  harness.Point(bar, "project.export");
  harness.snapshot().num_fragments = 1;
  harness.Click(bar, "project.export");
  EXPECT_NE(harness.widgets.Find("export.write"), nullptr);
}

TEST(AnnotateFloorPanel, ShowsAProposalWithItsNumbersAndTakesIt) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_floor");
  harness.snapshot().floor = MadeUpFloor();
  const std::string text = harness.Text(*panel);
  EXPECT_THAT(text, HasSubstr("picked"));
  EXPECT_THAT(text, HasSubstr("at 0.250 m along up"));
  EXPECT_THAT(text, HasSubstr("4321"));
  harness.view.tool = AnnotateTool::kFloor;
  harness.Click(*panel, "proposal.accept");
  EXPECT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  EXPECT_EQ(harness.view.tool, AnnotateTool::kSelect);
  EXPECT_TRUE(harness.view.reset);
  harness.Click(*panel, "proposal.cancel");
  EXPECT_NE(harness.sink.Last<CancelProposalCommand>(), nullptr);
}

TEST(AnnotateCandidatesPanel, TakesTheCandidateThatIsChosenByItsId) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_candidates");
  harness.snapshot().placement = MadeUpPlacement();
  auto& candidates = harness.snapshot().placement->candidates;
  std::swap(candidates[0], candidates[1]);  // the images preferred the second
  EXPECT_THAT(harness.Text(*panel), HasSubstr("2 found in 0.25 s."));
  harness.Click(*panel, "candidate.1");
  EXPECT_EQ(harness.view.candidate, 1);
  harness.Click(*panel, "proposal.accept");
  ASSERT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<AcceptProposalCommand>()->candidate, 0);
  harness.snapshot().placement->problem = "there are only 3 points";
  EXPECT_THAT(harness.Text(*panel),
              HasSubstr("there are only 3 points. It can be placed as it is"));
}

TEST(AnnotateRefinementPanel, SaysWhatMovedAndBetweenWhat) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_refinement");
  harness.snapshot().refinement = MadeUpRefinement();
  std::string text = harness.Text(*panel);
  for (const char* part : {"armchair_0", "converged", "+5.73", "20.0 mm",
                           "kept", "80 %", "was 50 %", "3.0 mm rms", "was 9.0"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  EXPECT_THAT(text, Not(HasSubstr("Tilt")));
  harness.snapshot().refinement->tilt_rad = 0.0175;
  EXPECT_THAT(harness.Text(*panel), HasSubstr("1.00\u00b0"));
  RefinementView& refinement = *harness.snapshot().refinement;
  refinement.has_images = true;
  refinement.has_scan = false;
  refinement.agreement_held_out = 0.61;
  refinement.before.agreement_held_out = 0.33;
  text = harness.Text(*panel);
  EXPECT_THAT(text, HasSubstr("On edges"));
  EXPECT_THAT(text, HasSubstr("61 %"));
  EXPECT_THAT(text, HasSubstr("was 33 %"));
  EXPECT_THAT(text, Not(HasSubstr("mm rms")));
  harness.Click(*panel, "proposal.accept");
  EXPECT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  harness.Click(*panel, "proposal.cancel");
  EXPECT_NE(harness.sink.Last<CancelProposalCommand>(), nullptr);
}

TEST(AnnotateRefinementPanel, OffersEachAloneAndSaysByHowMuchTheyDisagree) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_refinement");
  RefinementView refinement = MadeUpRefinement();
  for (const RefineBy by : {RefineBy::kBoth, RefineBy::kScan, RefineBy::kImages}) {
    RefinedPose found;
    found.by = by;
    found.horizontal_m = by == RefineBy::kImages ? 0.042 : 0.003;
    found.agreement_held_out = 0.57;
    refinement.found.push_back(found);
  }
  refinement.apart.horizontal_m = 0.039;
  refinement.apart.horizontal_std_m = 0.012;
  refinement.contradict = true;
  harness.snapshot().refinement = refinement;
  const std::string text = harness.Text(*panel);
  for (const char* part : {"Together", "By the scan", "By the images", "42 mm", "other images 57 %",
                           "39 mm", "12 mm", "contradict each other"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  harness.Click(*panel, "refined.images");
  EXPECT_EQ(harness.sink.Last<ChooseRefinementCommand>()->by, RefineBy::kImages);
}

TEST(AnnotateInstancePanel, TypedNumbersMoveTheObjectOnceTheyAreLeft) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  EXPECT_THAT(harness.Text(*panel), HasSubstr("Ada, 1 min 15 s spent"));
  harness.Type(*panel, "instance.x", "2.5");
  const auto* moved = harness.sink.Last<SetInstancePoseCommand>();
  ASSERT_NE(moved, nullptr);
  EXPECT_LT((moved->scan_from_object.translation() - Eigen::Vector3d(2.5, -1, 0)).norm(), 1e-9);
  EXPECT_EQ(harness.sink.commands.size(), 1u) << "one edit, not one for each digit";
  harness.Type(*panel, "instance.azimuth", "90");
  moved = harness.sink.Last<SetInstancePoseCommand>();
  EXPECT_NEAR(moved->scan_from_object.linear()(1, 0), 1, 1e-9);
}

TEST(AnnotateInstancePanel, ANumberCountsHoweverItsFieldIsLeft) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  harness.Type(*panel, "instance.x", "2.5", keys::kTab);
  const auto* moved = harness.sink.Last<SetInstancePoseCommand>();
  ASSERT_NE(moved, nullptr);
  EXPECT_NEAR(moved->scan_from_object.translation().x(), 2.5, 1e-9);
  // Tab has gone to the next field; a click on one above leaves that.
  ImGui::GetIO().AddInputCharactersUTF8("-3.25");
  harness.Draw(*panel, 2);
  harness.Click(*panel, "instance.name");
  ASSERT_EQ(harness.sink.commands.size(), 2u);
  moved = harness.sink.Last<SetInstancePoseCommand>();
  EXPECT_NEAR(moved->scan_from_object.translation().x(), 2.5, 1e-9) << "kept, though on its way";
  EXPECT_NEAR(moved->scan_from_object.translation().y(), -3.25, 1e-9);
}

TEST(AnnotateInstancePanel, WhatIsGivenUpOrSaysNothingNewIsNoEdit) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  harness.Type(*panel, "instance.x", "2.5", keys::kEscape);
  harness.snapshot().instances[0].scan_from_object.translation().x() = 1.00001;
  harness.Type(*panel, "instance.x", "1.00", keys::kTab);
  harness.Type(*panel, "instance.x", "nan", keys::kTab);
  harness.Type(*panel, "instance.x", "", keys::kTab);
  EXPECT_TRUE(harness.sink.commands.empty());
}

TEST(AnnotateInstancePanel, ItsButtonsAskForTheirCommands) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  harness.Click(*panel, "instance.refine");
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->id, "armchair_0");
  harness.Click(*panel, "instance.on_floor", 0.1f);
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->by, RefineBy::kBoth);
  harness.Click(*panel, "instance.by_images");
  EXPECT_FALSE(harness.sink.Last<RefineInstanceCommand>()->on_floor);
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->by, RefineBy::kImages);
  harness.Click(*panel, "instance.by_scan");
  EXPECT_EQ(harness.sink.Last<RefineInstanceCommand>()->by, RefineBy::kScan);
  harness.Click(*panel, "instance.again");
  EXPECT_EQ(harness.sink.Last<PlaceAgainCommand>()->id, "armchair_0");
  harness.Click(*panel, "instance.duplicate");
  EXPECT_EQ(harness.sink.Last<DuplicateInstanceCommand>()->id, "armchair_0");
  harness.Click(*panel, "instance.copy");
  ASSERT_TRUE(harness.view.copied.has_value());
  harness.snapshot().selected = "table_0";
  harness.Press(keys::kV, true);
  EXPECT_EQ(harness.sink.Last<DuplicateInstanceCommand>()->id, "armchair_0")
      << "beside what was copied, whatever is selected";
  harness.Click(*panel, "instance.tilt");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->id, "table_0");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.may_tilt, true);
  harness.Click(*panel, "instance.paste");
  EXPECT_EQ(harness.sink.Last<SetInstancePoseCommand>()->id, "table_0");
  EXPECT_EQ(harness.sink.Last<SetInstancePoseCommand>()->scan_from_object.translation().x(), 1);
  harness.Click(*panel, "instance.coarse");
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.fine, false);
  harness.Click(*panel, "instance.delete");
  EXPECT_EQ(harness.sink.Last<RemoveInstanceCommand>()->id, "table_0");
  harness.snapshot().instances[1].locked = true;
  harness.sink.commands.clear();
  harness.Click(*panel, "instance.delete");
  EXPECT_TRUE(harness.sink.commands.empty()) << "locked";
}

TEST(AnnotateInstancePanel, NameAndNoteBecomeEditsAndFollowUndo) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_instance");
  AnnotatedInstance& chair = harness.snapshot().instances[0];
  harness.Type(*panel, "instance.name", "throne");
  ASSERT_NE(harness.sink.Last<ChangeInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.id, "throne");
  chair.note = "wobbles";
  EXPECT_THAT(harness.Text(*panel), HasSubstr("wobbles"));
  chair.note.clear();  // it was undone
  EXPECT_THAT(harness.Text(*panel), Not(HasSubstr("wobbles")));
  const std::string note(300, 'x');
  chair.note = note;
  harness.Draw(*panel);
  harness.sink.commands.clear();
  harness.Click(*panel, "instance.note");
  ImGui::GetIO().AddInputCharacter('y');
  harness.Draw(*panel, 2);
  harness.Click(*panel, "instance.name");
  ASSERT_NE(harness.sink.Last<ChangeInstanceCommand>(), nullptr);
  EXPECT_EQ(harness.sink.Last<ChangeInstanceCommand>()->set.note->size(), 301u)
      << "a long note is not cut";
}

TEST(AnnotateCropPanel, ProposesTheBoxAndTakesWhatIsReady) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_crop");
  harness.view.tool = AnnotateTool::kCut;
  EXPECT_THAT(harness.Text(*panel), HasSubstr("Click the object in the scan"));
  EXPECT_EQ(harness.widgets.Find("crop.cut"), nullptr) << "there is nothing to cut yet";
  harness.view.crop_box = LevelBox{{1, -1, 0.5}, {0.7, 0.7, 1}, 0};
  harness.Type(*panel, "crop.name", "stool");
  harness.Type(*panel, "crop.size_z", "2", keys::kTab);
  EXPECT_NEAR(harness.view.crop_box->center.z(), 1, 1e-9) << "its bottom stays";
  harness.Click(*panel, "crop.fragment");
  harness.Click(*panel, "crop.cut");
  const auto* crop = harness.sink.Last<ProposeCropCommand>();
  ASSERT_NE(crop, nullptr);
  EXPECT_EQ(crop->id, "stool");
  EXPECT_TRUE(crop->fragment);
  EXPECT_EQ(crop->box.value().size_m.z(), 2);
  harness.snapshot().crop = CropView{"stool"};
  harness.Click(*panel, "proposal.accept");
  EXPECT_EQ(harness.sink.Last<AcceptProposalCommand>(), nullptr) << "it is still being cut";
  harness.snapshot().crop = MadeUpCrop();
  EXPECT_THAT(harness.Text(*panel), HasSubstr("0.40 x 0.50 x 0.60 m"));
  harness.Click(*panel, "proposal.accept");
  EXPECT_NE(harness.sink.Last<AcceptProposalCommand>(), nullptr);
  EXPECT_EQ(harness.view.tool, AnnotateTool::kSelect);
}

TEST(AnnotateSequencePanel, RegistersByWhatThereIs) {
  using How = AlignSequenceCommand::How;
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_sequence");
  harness.Click(*panel, "sequence.by_pairs");
  EXPECT_TRUE(harness.sink.commands.empty()) << "without pairs";
  harness.snapshot().pairs.resize(3);
  harness.snapshot().pairs[0].seen_at = Eigen::Vector2d(1, 2);
  harness.snapshot().pairs[0].residual_px = 3.25;
  const std::string text = harness.Text(*panel);
  EXPECT_THAT(text, HasSubstr("3.2 px"));
  EXPECT_THAT(text, HasSubstr("not seen"));
  harness.Click(*panel, "sequence.remove.1");
  EXPECT_EQ(harness.sink.Last<RemovePairCommand>()->index, 1u);
  harness.Click(*panel, "sequence.by_pairs");
  EXPECT_EQ(harness.sink.Last<AlignSequenceCommand>()->how, How::kPairs);
  harness.Type(*panel, "sequence.objects.field", "walk.plb");
  EXPECT_EQ(harness.sink.Last<AlignSequenceCommand>()->how, How::kObjects);
  EXPECT_EQ(harness.sink.Last<AlignSequenceCommand>()->file, "walk.plb");
}

TEST(AnnotateSequencePanel, ShowsAProposalWithItsResiduals) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_sequence");
  harness.snapshot().sequence_alignment = MadeUpAlignment();
  std::string text = harness.Text(*panel);
  for (const char* part : {"By objects", "12.3 cm", "table 2", "1.5 cm", "none near"}) {
    EXPECT_THAT(text, HasSubstr(part));
  }
  harness.snapshot().sequence_alignment->problem = "no pair fits";
  text = harness.Text(*panel);
  EXPECT_THAT(text, HasSubstr("no pair fits"));
  harness.Click(*panel, "proposal.accept");
  EXPECT_EQ(harness.sink.Last<AcceptProposalCommand>(), nullptr);
}

TEST(AnnotateFramePanel, AsksForItsFirstFrameOnce) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_frame");
  harness.Draw(*panel, 5);
  ASSERT_EQ(harness.sink.commands.size(), 1u);
  EXPECT_EQ(harness.sink.Last<ShowFrameCommand>()->frame, 20);
}

TEST(AnnotateFramePanel, AClickCompletesAPairThatBeganInTheScan) {
  AnnotateHarness harness;
  const auto panel = MakeAnnotatePanel("annotate_frame");
  harness.size = {700, 400};
  harness.snapshot().frame = FrameView{7, cv::Mat(90, 160, CV_8UC3, cv::Scalar(60, 60, 60)), ""};
  harness.Click(*panel, "frame.view");
  EXPECT_EQ(harness.sink.Last<AddPairCommand>(), nullptr);
  ASSERT_TRUE(harness.view.pick_pixel.has_value()) << "half a pair";
  harness.view.pick_pixel.reset();
  harness.view.pick_in_scan = Eigen::Vector3d(1, 2, 3);
  harness.Click(*panel, "frame.view");
  const auto* pair = harness.sink.Last<AddPairCommand>();
  ASSERT_NE(pair, nullptr);
  EXPECT_EQ(pair->in_scan, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(pair->frame, 7);
  EXPECT_NEAR(pair->pixel.x(), 80, 1);
  EXPECT_FALSE(harness.view.pick_in_scan.has_value());
}

}  // namespace
}  // namespace plumbline
